"""Boards opened and closed many times. Apart from robustness_test.py, since it takes as long as all of that."""

from robustness_test import run


def test_a_thousand_boards_leave_nothing():
    run(
        """
def held():
    return len(os.listdir("/proc/self/fd")), len(os.listdir("/proc/self/task"))

def memory():
    return int(open("/proc/self/statm").read().split()[1]) * 4096

for _ in range(100):
    gicube.open().close()
first, before = held(), memory()
for _ in range(900):
    with gicube.open() as board:
        board.counters
assert held() == first, (held(), first)
assert memory() - before < 8 << 20, memory() - before
""",
        seconds=500,
    )
