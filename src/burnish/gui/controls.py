"""Small help with the controls of a page: they change only when they have to, and what they do may be refused."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import viser

from burnish.errors import BurnishError
from burnish.gui.stage import Offer


class WatchingError(BurnishError):
    """Somebody who only watches wanted to do something."""


def put(handle: Any, **values: Any) -> None:
    """Set what differs: every other message would be sent for nothing."""
    for name, value in values.items():
        if getattr(handle, name) != value:
            setattr(handle, name, value)


def allow(handle: Any, offer: Offer, hint: str = "") -> None:
    """Switch a control on or off; its hint says why it is off, or else what it is."""
    put(handle, disabled=not offer.may, hint=offer.why or hint or None)


def guarded(
    tell: Callable[[viser.ClientHandle | None, str], None], act: Callable[[Any], object]
) -> Callable[[Any], None]:
    """A callback whose refusal is told instead of raised.

    Args:
        tell: shows a sentence to the client that caused it, or to everybody.
        act: is given the event.
    """

    def callback(event: Any) -> None:
        try:
            act(event)
        except BurnishError as error:
            tell(event.client, " ".join(str(error).split()))

    return callback


def notify(client: viser.ClientHandle | None, sentence: str) -> None:
    """A refusal in the corner of a client's page."""
    if client is not None:
        client.add_notification("Refused", sentence, color="red", auto_close_seconds=12.0)
