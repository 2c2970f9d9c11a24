"""`iw-check-agent`: a scripted simulator that checks whether a program, in any language, keeps the contract."""
