"""The contract: messages, names, keys, codecs and the link. Any room may import it; it imports none."""
