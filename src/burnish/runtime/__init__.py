"""One cycle, safely: the loop and the supervisor."""
