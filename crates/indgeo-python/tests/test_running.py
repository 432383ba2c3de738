import signal
import threading
import time

import numpy as np
import pytest
from shapes import wave

import indgeo


def cloud(n):
    return np.random.default_rng(7).uniform(-1, 2, (n, 3))


def test_progress_is_told_and_ends_with_everything():
    heard = []
    indgeo.project(wave(), cloud(60_000), progress=lambda text, done, total: heard.append((text, done, total)), threads=1)
    assert heard and all(0 <= done <= total or total == 0 for _, done, total in heard)
    assert any(text == "projecting" for text, _, _ in heard)


def test_an_interrupt_stops_the_work():
    points = cloud(3_000_000)
    signal.signal(signal.SIGALRM, signal.default_int_handler)
    signal.setitimer(signal.ITIMER_REAL, 1.0)
    began = time.monotonic()
    with pytest.raises(KeyboardInterrupt):
        indgeo.project(wave(), points, threads=1)
    assert time.monotonic() - began < 6


def test_an_error_in_the_callback_comes_out():
    def stop(*_):
        raise RuntimeError("enough")

    with pytest.raises(RuntimeError, match="enough"):
        indgeo.project(wave(), cloud(60_000), progress=stop, threads=1)


def test_other_threads_of_python_go_on():
    ticks = []

    def tick():
        while not done.is_set():
            ticks.append(time.monotonic())
            time.sleep(0.002)

    done = threading.Event()
    other = threading.Thread(target=tick)
    other.start()
    indgeo.project(wave(), cloud(200_000), threads=1)
    done.set()
    other.join()
    assert len(ticks) > 20


def test_two_calls_at_once_do_not_mix():
    points = [cloud(20_000) + shift for shift in range(4)]
    alone = [indgeo.project(wave(), p).distance for p in points]
    together = [None] * 4

    def work(index):
        together[index] = indgeo.project(wave(), points[index]).distance

    threads = [threading.Thread(target=work, args=(index,)) for index in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert all(np.array_equal(a, b) for a, b in zip(alone, together))
