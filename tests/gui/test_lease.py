"""One commander at most, and none that is not there."""

from __future__ import annotations

import threading
import time

from burnish.gui.bucket import Bucket
from burnish.gui.lease import Lease


class Clock:
    """Told what time it is."""

    now = 100.0

    def __call__(self) -> float:
        return self.now


def test_second_one_watches_until_the_first_leaves() -> None:
    lease = Lease()
    first = lease.take(1)
    assert first is not None
    assert lease.take(2) is None
    assert lease.take(1) == first
    assert lease.renew(2, lease.clock()) is None
    assert lease.leave(2) is None
    assert lease.holds(1)
    assert lease.leave(1) == first
    assert not lease.holds(1)
    second = lease.take(2)
    assert second is not None
    assert second.number > first.number


def test_renewed_lease_lasts_and_another_ends_for_good() -> None:
    clock = Clock()
    lease = Lease(term=0.25, clock=clock)
    first = lease.take(1)
    for _ in range(10):
        clock.now += 0.2
        assert lease.renew(1, clock.now) == first
    clock.now += 0.26
    assert lease.renew(1, clock.now) is None
    assert lease.grant is None
    again = lease.take(1)
    assert again is not None
    assert again != first


def test_proof_counts_from_when_it_was_sent_and_never_from_the_future() -> None:
    clock = Clock()
    lease = Lease(term=0.25, clock=clock)
    lease.take(1)
    clock.now += 0.2
    assert lease.renew(1, clock.now - 0.15) is not None
    clock.now += 0.11
    assert lease.grant is None
    lease.take(1)
    lease.renew(1, clock.now + 1000.0)
    clock.now += 0.26
    assert lease.grant is None


def test_proof_that_is_no_number_keeps_nothing_alive() -> None:
    clock = Clock()
    lease = Lease(term=0.25, clock=clock)
    lease.take(1)
    lease.renew(1, float("nan"))
    clock.now += 0.26
    assert lease.grant is None


def interrupted() -> float:
    """A clock that lets the other threads go first, so that whatever is not locked goes wrong."""
    time.sleep(1e-5)
    return time.monotonic()


def test_exactly_one_of_many_gets_the_command() -> None:
    lease, threads = Lease(term=60.0, clock=interrupted), 8
    for _ in range(100):
        barrier, won = threading.Barrier(threads), []

        def race(who: int, barrier: threading.Barrier = barrier, won: list[int] = won) -> None:
            barrier.wait()
            if lease.take(who) is not None:
                won.append(who)

        racers = [threading.Thread(target=race, args=(who,)) for who in range(threads)]
        for racer in racers:
            racer.start()
        for racer in racers:
            racer.join()
        assert len(won) == 1
        assert lease.leave(won[0]) is not None


def test_bucket_gives_its_burst_and_then_its_rate() -> None:
    clock = Clock()
    bucket = Bucket(rate=10.0, most=20.0, clock=clock)
    assert sum(bucket.take() for _ in range(50)) == 20
    clock.now += 1.0
    assert sum(bucket.take() for _ in range(50)) == 10
    clock.now += 1e6
    assert sum(bucket.take() for _ in range(50)) == 20
