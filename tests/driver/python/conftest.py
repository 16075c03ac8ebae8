"""What the tests of the Python package share."""

import numpy as np
import pytest

import gicube

pytest_plugins = ["gicube.testing"]


def ball(size=32, radius=10):
    """uint8: 200 inside, 0 outside."""
    z, y, x = np.mgrid[0:size, 0:size, 0:size]
    middle = (size - 1) / 2
    return (((x - middle) ** 2 + (y - middle) ** 2 + (z - middle) ** 2) < radius**2).astype("u1") * 200


LOOK = gicube.TransferFunction([(0, (1, 1, 1))], [(100, 0), (100, 1)])


def view_of_ball(**fields):
    return gicube.fit_view(gicube.Volume(ball()), [LOOK], **{"width": 64, "height": 64, **fields})


@pytest.fixture
def loaded(board):
    """A board with a white ball."""
    board.load_volume(ball())
    board.set_transfer_function(LOOK)
    return board
