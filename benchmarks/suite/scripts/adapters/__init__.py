"""One solver per file. A package of your own may bring such a file: its entry point in the group `saltus_bench` names the
class (peers.py describes the members)."""
