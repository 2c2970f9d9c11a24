"""`iw-check-agent`: does a program, in any language, keep the contract? A scripted simulator plays to it and looks."""
