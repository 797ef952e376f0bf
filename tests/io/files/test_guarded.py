"""Whatever a parser does, the process that asked lives on and is told; the next question is answered."""

import math
import os
import time

import numpy as np
import pytest

from ipcli.io.files.guarded import ParserFailed, guarded


def echo(value):
    return value


def crash():
    os.abort()


def loop():
    while True:
        pass


def hunger():
    return len(np.ones(1 << 29))  # 4 GiB


def refuse():
    raise ValueError("no such thing\nat all")


def chatter():
    os.write(1, b"noise")
    print("noise", flush=True)
    return os.getpid()


def test_the_answer_is_that_of_the_function():
    assert guarded(math.hypot, 3.0, 4.0) == 5.0
    np.testing.assert_array_equal(guarded(echo, np.arange(5)), np.arange(5))


def test_one_child_that_prints_as_it_likes_serves_many():
    first = guarded(chatter)
    assert first != os.getpid()
    assert guarded(chatter) == first


@pytest.mark.parametrize(
    ("parse", "because"),
    [
        (crash, "crashed .SIGABRT"),
        (loop, "took longer than 0.3 s"),
        (hunger, "more than 0.5 GiB"),
        (refuse, "^no such thing at all$"),
    ],
)
def test_what_goes_wrong_is_said_and_the_next_question_is_answered(parse, because):
    guarded(echo, 0)
    started = time.monotonic()
    with pytest.raises(ParserFailed, match=because):
        guarded(parse, seconds=0.3, memory=1 << 29)
    assert time.monotonic() - started < 20
    assert guarded(echo, 7) == 7
