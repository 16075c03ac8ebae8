"""An application against boards with slow buses and failing cards, by pytest: pytest deadline_test.py"""

import numpy as np
import pytest

import gicube
from gicube.testing import BoardSetup, Window, assert_counter, assert_time

SCAN = np.random.default_rng(1).integers(1, 256, (64, 64, 64)).astype("u1")


def upload(board: gicube.Board) -> None:
    """The application: what it uploads."""
    board.load_volume(SCAN)
    board.set_transfer_function(gicube.TransferFunction([(0, (1, 1, 1))], [(0, 0.02)]))


def picture(board: gicube.Board) -> gicube.Image:
    """The picture, and the recovery when its card's memory fails."""
    while True:
        try:
            return board.render(gicube.fit_view(gicube.Volume(SCAN), width=32, height=32))
        except gicube.MemoryFault:
            pass  # nothing has changed, and the call may be made again


@pytest.mark.board(bus=["pci33", "agp2x"])
def test_upload_is_bound_by_the_bus(board: gicube.Board, board_setup: BoardSetup) -> None:
    bytes_per_second = {"pci33": 131.8e6, "agp2x": 470.6e6}[board_setup.bus]  # with the bus's own overhead
    with Window(board) as window:
        upload(board)
    assert_counter(window, "bus.volume.bytes", SCAN.size * 36 / 8)  # 36 bits a voxel
    assert_time(window, SCAN.size * 36 / 8 / bytes_per_second * 1e12, 0.1)


@pytest.mark.board(faults="random { seed: 2 kinds: [memory_detected] mean_messages: 3 first_message: 1 }")
def test_a_picture_survives_errors_of_the_memory(board: gicube.Board) -> None:
    upload(board)
    with gicube.open() as healthy:
        upload(healthy)
        assert picture(board) == picture(healthy)


@pytest.mark.board(faults="fault { direction: down message: 25 kind: kill }")
def test_a_card_that_dies_is_reported(board: gicube.Board) -> None:
    with pytest.raises(gicube.DeviceLost):
        upload(board)


def test_a_frame_that_takes_too_long_is_noticed(board: gicube.Board) -> None:
    upload(board)
    board.set_time_limit(10**6)  # a microsecond
    with pytest.raises(gicube.DeadlinePassed):
        board.render(gicube.fit_view(gicube.Volume(SCAN)))
