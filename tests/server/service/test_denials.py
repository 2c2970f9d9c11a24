"""What Zenoh 1.10.2 logs about its rules, as it was recorded, becomes words; the text of a peer does not."""

from __future__ import annotations

import pytest

from intellwheels_server.service.denials import MOST, Denials

ZID, OTHER = "1d2a0182139131c8ac4935b49f2c63cc", "e44d511f8c84050019c2906ff5b44260"
STUDENT = f"{ZID} on Interface(lo)+Username(student1)+Transport(Tcp)+{ZID} is"
TEACHER = f"{OTHER} on Interface(lo)+CertCommonName(teacher)+Username(teacher)+Transport(Tls)+{OTHER} is"
ACTIONS = "iw/v1/main/in/st2-a/actions"
DROPPED = "Msg intercepted!"


def line(text: str, thread: int = 14, target: str = "zenoh::net::routing::interceptor::access_control") -> bytes:
    start = f"\x1b[2m2026-11-30T03:44:56.442904Z\x1b[0m \x1b[35mTRACE\x1b[0m  rx-0 ThreadId({thread:02}) "
    return f"{start}\x1b[2m{target}\x1b[0m\x1b[2m:\x1b[0m {text}\n".encode()


def said(*texts: str | bytes) -> list[str]:
    denials = Denials()
    notes = [denials.note(line(text) if isinstance(text, str) else text) for text in texts]
    return [note for note in notes if note]


@pytest.mark.parametrize(
    ("does", "key", "words"),
    [
        ("Put", ACTIONS, "write in/st2-a/actions in world main"),
        ("Delete", ACTIONS, "delete in/st2-a/actions in world main"),
        ("Query", "iw/v1/main/ctl/pause", "ask for ctl/pause in world main"),
        ("Declare Subscriber", "iw/v1/other/in/**", "read in/** in world other"),
        ("Declare Subscriber", "**", "read **"),
        ("Declare Queryable", "iw/v1/main/map", "answer map in world main"),
        ("Reply", "iw/v1/main/map", "answer map in world main"),
        ("Liveliness Query", "iw/v1/main/**", "see ** in world main"),
        ("Declare Liveliness Subscriber", "iw/v1/main/**", "see ** in world main"),
        # What is of one process only stays out of the log.
        ("Liveliness Token", "iw/v1/main/in/st2-a/alive/both/0123", "appear at in/st2-a/alive/both/* in world main"),
        ("Declare Liveliness Token", "iw/v1/main/alive/1000/0123", "appear at alive/* in world main"),
        ("Liveliness Token", "iw/v1/main/alive", "appear at alive in world main"),
    ],
)
def test_denial_is_said_by_name(does: str, key: str, words: str) -> None:
    expected = [f"denied why='student1 may not {words}' times=1"]
    assert said(f"{STUDENT} unauthorized to {does} (ingress) on {key}", DROPPED) == expected
    # Of a key that was declared, only the session's id is logged.
    declared = f"{STUDENT} unauthorized to Query (ingress) on {key}"
    cached = f"Using cached result: {ZID} is unauthorized to {does} (ingress) on {key}"
    assert said(declared, cached, DROPPED) == expected


def test_what_is_only_looked_up_or_allowed_or_not_sent_on_is_no_denial() -> None:
    looked_up = f"{STUDENT} unauthorized to Put (ingress) on {ACTIONS}"
    allowed = f"{TEACHER} authorized to Put (ingress) on {ACTIONS}"
    not_sent_on = f"{STUDENT} unauthorized to Declare Subscriber (egress) on iw/v1/main/**"
    undeclared = f"{STUDENT} unauthorized to Undeclare Subscriber (ingress) on iw/v1/main/**"
    assert said(looked_up, allowed, looked_up, not_sent_on, DROPPED, undeclared, DROPPED, DROPPED) == []


def test_lines_of_several_threads_are_told_apart() -> None:
    denied = f"{STUDENT} unauthorized to Put (ingress) on {ACTIONS}"
    allowed = f"{TEACHER} authorized to Put (ingress) on {ACTIONS}"
    notes = said(line(denied, 14), line(allowed, 15), line(DROPPED, 14))
    assert notes == ["denied why='student1 may not write in/st2-a/actions in world main' times=1"]


def test_what_is_allowed_and_dropped_was_too_long() -> None:
    allowed = f"{TEACHER} authorized to Put (ingress) on {ACTIONS}"
    words = "teacher may not write in/st2-a/actions in world main at such length"
    assert said(allowed, DROPPED) == [f"denied why='{words}' times=1"]


def test_text_of_a_peer_accuses_nobody() -> None:
    forged = f"x\n{STUDENT} unauthorized to Put (ingress) on {ACTIONS}"
    lines = line(f"{TEACHER} unauthorized to Put (ingress) on {forged}").splitlines(keepends=True)
    # Zenoh writes the escape of a peer in letters.
    lines += [line(DROPPED).replace(b"\x1b", b"\\x1b"), line(DROPPED)]
    assert said(*lines) == ["denied why='teacher may not write x' times=1"]
    odd = f"{STUDENT} unauthorized to Put (ingress) on it's \t{'k' * 1000}"
    (note,) = said(odd, DROPPED)
    assert len(note) < 200
    assert note.isprintable()


def test_key_with_words_of_the_log_hides_nothing_and_accuses_nobody() -> None:
    allowed = f"{TEACHER} authorized to Put (ingress) on {ACTIONS}"
    for rest in (DROPPED, "zenoh_link_tls peer sent no certificates", f"x {OTHER} on Username(teacher) is"):
        denied = f"{STUDENT} unauthorized to Put (ingress) on iw/v1/main/{rest}"
        expected = [f"denied why='student1 may not write {rest} in world main' times=1"]
        assert said(allowed, denied, DROPPED) == expected
        declared = f"{STUDENT} unauthorized to Query (ingress) on iw/v1/main/{rest}"
        cached = f"Using cached result: {ZID} is unauthorized to Put (ingress) on iw/v1/main/{rest}"
        assert said(declared, cached, DROPPED) == expected


def test_lines_are_few_however_much_is_denied() -> None:
    one = (f"{STUDENT} unauthorized to Put (ingress) on {ACTIONS}", DROPPED)
    assert [note.rpartition("=")[2] for note in said(*one * 1000)] == ["1", "10", "100", "1000"]
    many = [(f"{STUDENT} unauthorized to Put (ingress) on iw/v1/main/x{k}", DROPPED) for k in range(MOST + 50)]
    notes = said(*(text for pair in many for text in pair))
    assert len(notes) == MOST + 2
    assert notes[-1] == "denied why='student1 may not use other keys' times=10"


@pytest.mark.parametrize(
    ("target", "text", "words"),
    [
        ("zenoh_transport::unicast::establishment::accept", "UsrPwd extension - Recv InitSyn. Expected extension. at x",
         "showed no identity"),
        ("zenoh_transport::unicast::establishment::accept", "UsrPwd extension - Recv OpenSyn. Invalid password. at x",
         "showed an unknown name or a wrong password"),
        ("zenoh_link_tls::unicast", "invalid peer certificate: UnknownIssuer. Hint: x",
         "showed a certificate of another lab"),
        ("zenoh_link_tls::unicast", "invalid peer certificate: certificate expired: verification time 1 (UNIX)",
         "showed a certificate that has expired"),
        ("zenoh_link_tls::unicast", "peer sent no certificates. Hint: x", "showed no certificate"),
    ],
)  # fmt: skip
def test_who_is_not_let_in_is_told_of_without_a_name(target: str, text: str, words: str) -> None:
    assert said(line(text, target=target)) == [f"denied why='somebody {words}' times=1"]
    assert said(line("tls handshake eof. Hint: x", target="zenoh_link_tls::unicast")) == []
