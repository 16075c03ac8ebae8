"""Several boards from Python."""

import pytest
from conftest import LOOK, ball, view_of_ball

import gicube

BLOCKS = "set=asic.block_voxels=8&set=asic.max_volume_voxels=64"


@pytest.fixture(name="group")
def three_boards():
    with gicube.BoardGroup(f"emu:?boards=3&{BLOCKS}") as group:
        group.on_all(lambda board: board.load_volume(ball()))
        group.on_all(lambda board: board.set_transfer_function(LOOK))
        yield group


def some_rays():
    return gicube.rays_between([[2, 3 + i, 16] for i in range(20)], [[29, 3 + i, 15] for i in range(20)])


def test_three_boards_have_the_picture_and_the_rays_of_one(group):
    with gicube.open(f"emu:?{BLOCKS}") as one:
        one.load_volume(ball())
        one.set_transfer_function(LOOK)
        picture = one.render(view_of_ball())
        batch = one.receive(one.submit(some_rays(), type=gicube.RayType.OPACITY, opacity=1))
    assert len(group) == 3 and group.buses is gicube.HostBuses.SHARED
    assert group.render(view_of_ball()) == picture
    assert (group.trace(some_rays(), type=gicube.RayType.OPACITY, opacity=1).rays == batch.rays).all()


def test_the_parts_of_each_boards_time_sum_to_the_clock(group):
    group.render(view_of_ball())
    assert len(group.times) == 3
    for time in group.times:
        assert time.bus > 0 and time.bus + time.work + time.bus_wait + time.skew == group.now
    assert group.counters["dsp.viewing_rays"] == view_of_ball().width * view_of_ball().height


def test_boards_with_a_bus_each_do_not_wait_for_it():
    with gicube.BoardGroup([f"emu:?{BLOCKS}"] * 2, buses=gicube.HostBuses.OWN) as group:
        group.on_all(lambda board: board.load_volume(ball()))
        assert group.buses is gicube.HostBuses.OWN
        assert all(time.bus_wait == 0 for time in group.times)


def test_what_one_board_raises_comes_from_the_call_and_the_others_go_on(group):
    def work(board):
        if board is group.boards[1]:
            raise ValueError("not this one")
        board.set_shading(gicube.Shading())

    with pytest.raises(ValueError, match="not this one"):
        group.on_all(work)
    assert group.render(view_of_ball()).alpha.max() > 0


def test_wrong_options_are_named():
    with pytest.raises(TypeError, match="no option boards"):
        gicube.BoardGroup("emu:", boards=3)
    with pytest.raises(gicube.BadArgument, match="addresses"):
        gicube.BoardGroup([])
    with pytest.raises(gicube.BadArgument, match="buses"):
        gicube.BoardGroup("emu:?boards=2", buses="none")


def test_a_closed_group_says_so(group):
    group.close()
    group.close()
    with pytest.raises(gicube.DeviceLost):
        group.render(view_of_ball())
    with pytest.raises(gicube.DeviceLost):
        group.boards[0].render(view_of_ball())
