"""Lots of the sub-steps; what they lead to is in `test_contact`."""

from intellwheels_server.world.kernels.contact_steps import lot


def test_lots_are_splitmix64() -> None:
    # The first outputs of SplitMix64 with seed 1234567, from its reference code.
    published = [
        6457827717110365317,
        3203168211198807973,
        9817491932198370423,
        4593380528125082431,
        16408922859458223821,
    ]
    assert [int(lot(1234567, 0, k)) for k in range(5)] == published
    assert lot(1234567, 1, 0) == lot(1234567, 0, 1024)
