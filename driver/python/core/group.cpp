// gicube._core.BoardGroup: several boards in one host.
#include "gicube/board_group.h"

#include "call.h"

namespace gicube::python {
namespace {

using Group = Owned<BoardGroup>;

std::unique_ptr<Group> open_group(const py::object& addresses, const py::dict& given) {
  auto options = read_as<GroupOptions>(given, "");
  options.board.while_waiting = take_signals;
  const bool is_one = py::isinstance<py::str>(addresses);
  const auto all = is_one ? std::vector{read_as<std::string>(addresses, "addresses")}
                          : read_as<std::vector<std::string>>(addresses, "addresses");
  return without_interpreter([&] {
    auto group = is_one ? BoardGroup::open(all[0], options) : BoardGroup::open(all, options);
    return std::make_unique<Group>(std::make_shared<BoardGroup>(std::move(group)));
  });
}

// A board keeps its group.
std::unique_ptr<Handle> board_of(const Group& self, std::size_t index) {
  const auto group = self.board();
  if (index >= group->size()) throw py::index_error("the group has " + std::to_string(group->size()) + " boards");
  return std::make_unique<Handle>(std::shared_ptr<Board>(group, &group->board(index)));
}

}  // namespace

void add_group(py::module_& module) {
  py::class_<Group> type(module, "BoardGroup");
  type.def(py::init(&open_group));
  type.def("close", &Group::close);
  type.def("size", call(&BoardGroup::size));
  type.def("board", &board_of);
  type.def_property_readonly("buses", call(&BoardGroup::buses));
  type.def("on_all", [](const Group& self, const py::function& work) {
    const auto group = self.board();
    without_interpreter(
        [&] { group->on_all([&](Board&, std::size_t index) { with_interpreter([&] { work(index); }); }); });
  });
  type.def("render", call(&BoardGroup::render, "", "progress"));
  type.def("trace", call(&BoardGroup::trace, "rays", ""));
  type.def_property_readonly("now", call(&BoardGroup::now));
  type.def("times", call(&BoardGroup::times));
  type.def("counters", call(&BoardGroup::counters));
}

}  // namespace gicube::python
