from __future__ import annotations

import hashlib

from intellwheels_schemas.log_chain import Chain, has_more_than_a_line, is_sealed, unsealed


def test_checksum_is_the_one_that_the_file_describes() -> None:
    chain = Chain()
    first, second = chain.seal(b'{"A":1,"Chain":""}'), chain.seal(b'{"B":2}')
    one = hashlib.blake2b(b'{"A":1', digest_size=8).hexdigest()
    two = hashlib.blake2b(one.encode() + b'{"B":2', digest_size=8).hexdigest()
    assert first == b'{"A":1,"Chain":"%b"}' % one.encode()
    assert second == b'{"B":2,"Chain":"%b"}' % two.encode()
    assert chain.value == two
    assert unsealed(second) == b'{"B":2}'


def test_lines_in_order_are_right_and_the_others_are_wrong() -> None:
    chain = Chain()
    lines = [chain.seal(b'{"A":%d}' % k) for k in range(3)]
    reader = Chain()
    assert [reader.check(line) for line in lines] == [None] * 3
    assert reader.value == chain.value
    assert "expected checksum" in (Chain().check(lines[1]) or "")
    assert "at its end, got none" in (Chain().check(b"") or "")


def test_sealed_line_is_told_from_a_part_of_one_and_from_more() -> None:
    line = Chain().seal(b'{"A":1}')
    assert is_sealed(line)
    assert not any(is_sealed(line[:k]) for k in range(len(line)))
    assert not has_more_than_a_line(line)
    assert not has_more_than_a_line(line[:-1])
    assert has_more_than_a_line(line + b"x")
