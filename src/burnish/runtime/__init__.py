"""One cycle, safely: the loop, the supervisor and the recorder."""
