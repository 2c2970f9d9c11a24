from __future__ import annotations

from intellwheels_schemas.session_count import MAX_SESSIONS, SessionCount


def test_sessions_beyond_the_number_are_refused_until_one_ends() -> None:
    count = SessionCount(2)
    assert [count.opened(f"tcp/10.0.0.7:{port}", None) for port in (1, 2)] == ["", ""]
    assert count.opened("tcp/10.0.0.7:3", None) == "closed session of=10.0.0.7 why='it has 2 already' closed=1"
    assert count.opened("tcp/10.0.0.8:1", None) == ""
    count.closed("tcp/10.0.0.7:3", None)  # the end of the refused one frees nothing
    assert count.opened("tcp/10.0.0.7:4", None)
    count.closed("tcp/10.0.0.7:1", None)
    assert count.opened("tcp/10.0.0.7:5", None) == ""


def test_certificates_count_by_name_and_this_machine_only_if_asked() -> None:
    count = SessionCount(None)
    for port in range(2 * MAX_SESSIONS):
        assert count.opened(f"tcp/127.0.0.1:{port}", None) == ""
    words = [count.opened(f"tls/127.0.0.1:{port}", "bridge1") for port in range(MAX_SESSIONS + 1)]
    assert [bool(word) for word in words] == [*[False] * MAX_SESSIONS, True]
    assert count.opened("tls/[2001:db8::1]:1", None) == ""
    asked = SessionCount(1)
    assert (asked.opened("tcp/127.0.0.1:1", None), bool(asked.opened("tcp/127.0.0.1:2", None))) == ("", True)


def test_first_tenth_and_hundredth_refusals_are_told() -> None:
    count = SessionCount(1)
    assert count.opened("tcp/10.0.0.7:1", None) == ""
    told = [
        number for number in range(1, 1001) if count.is_worth_a_line(count.opened(f"tcp/10.0.0.7:{number + 1}", None))
    ]
    assert told == [1, 10, 100, 1000]
