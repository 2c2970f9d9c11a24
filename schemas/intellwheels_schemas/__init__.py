"""The contract: messages, names, keys, codecs and the link. All rooms may import it. It imports no other room."""
