"""Experiments: scenes run as processes, watched, judged and reported. They meet the other rooms on the wire."""
