// Opening boards, their description, simulated time, counters.
#include "call.h"
#include "gicube/enumerate.h"

struct GICUBE_HIDDEN gicube_counter_list {
  gicube::Counters counters;
};

struct GICUBE_HIDDEN gicube_found_list {
  std::vector<gicube::FoundBoard> boards;
};

namespace gicube::c_api {
namespace {

OpenOptions to_options(const gicube_open_options* given) {
  if (given == nullptr) return {};
  gicube_open_options record;
  auto options = read_fields<OpenOptions>("options", given, record);
  if (record.capture != nullptr) options.capture = record.capture;
  if (record.token_file != nullptr) options.token_file = record.token_file;
  if (record.ca_file != nullptr) options.ca_file = record.ca_file;
  if (record.log != nullptr) {
    options.log = [log = record.log, user = record.log_user](const std::string& sentence) {
      log(user, sentence.c_str());
    };
  }
  return options;
}

}  // namespace
}  // namespace gicube::c_api

using namespace gicube::c_api;

extern "C" {

gicube_status gicube_open_options_init(gicube_open_options* options, size_t size) {
  return init<gicube::OpenOptions>("options", options, size);
}

gicube_status gicube_board_info_init(gicube_board_info* info, size_t size) {
  return call([&] { write_record("info", info, size, {}); });
}

gicube_status gicube_found_board_init(gicube_found_board* found, size_t size) {
  return call([&] { write_record("found", found, size, {}); });
}

gicube_status gicube_enumerate(gicube_found_list** list) {
  return call([&] {
    checked("list", list) = nullptr;
    *list = new gicube_found_list{gicube::enumerate()};
  });
}

void gicube_found_free(gicube_found_list* list) { delete list; }

size_t gicube_found_count(const gicube_found_list* list) { return list == nullptr ? 0 : list->boards.size(); }

gicube_status gicube_found_at(const gicube_found_list* list, size_t index, gicube_found_board* found) {
  return call([&] {
    const auto& boards = checked("list", list).boards;
    gicube::expect(index < boards.size(), "index", fmt::format("less than {}", boards.size()), index);
    auto record = to_record<gicube_found_board>(boards[index]);
    record.uri = boards[index].uri.c_str();
    record.product = boards[index].product.c_str();
    record.version = boards[index].version.c_str();
    record.owner = boards[index].owner.c_str();
    write_record("found", found, record);
  });
}

gicube_status gicube_open(const char* uri, const gicube_open_options* options, gicube_board** board) {
  return call([&] {
    checked("board", board) = nullptr;
    checked("uri", uri);
    *board = new gicube_board(gicube::Board::open(uri, to_options(options)));
  });
}

gicube_status gicube_reopen(gicube_board* board, gicube_reopened* reopened) {
  return on_board(board, [&](gicube_board& handle) {
    const gicube::Reopened found = handle.board.reopen();
    if (!found.resumed) {  // the framebuffer is gone
      const std::scoped_lock lock(handle.mutex);
      handle.framebuffer = {};
    }
    if (reopened != nullptr) *reopened = to_record<gicube_reopened>(found);
  });
}

gicube_status gicube_save(gicube_board* board, const char* file) {
  return on_board(board, [&](gicube_board& handle) { handle.board.save(std::string(&checked("file", file))); });
}

gicube_status gicube_restore(gicube_board* board, const char* file) {
  return on_board(board, [&](gicube_board& handle) {
    handle.board.restore(std::string(&checked("file", file)));
    const std::scoped_lock lock(handle.mutex);
    handle.framebuffer = {};
  });
}

void gicube_close(gicube_board* board) { delete board; }

gicube_status gicube_get_info(gicube_board* board, gicube_board_info* info) {
  return on_board(board, [&](gicube_board& handle) {
    write_record("info", info, to_record<gicube_board_info>(handle.board.info()));
  });
}

gicube_status gicube_now(gicube_board* board, uint64_t* now_ps) {
  return call([&] { checked("now_ps", now_ps) = checked_board(board).board.now(); });
}

gicube_status gicube_host_compute(gicube_board* board, uint64_t duration_ps) {
  return on_board(board, [&](gicube_board& handle) { handle.board.host_compute(duration_ps); });
}

gicube_status gicube_set_time_limit(gicube_board* board, uint64_t limit_ps) {
  return on_board(board, [&](gicube_board& handle) { handle.board.set_time_limit(limit_ps); });
}

const char* gicube_why_invisible(gicube_board* board) {
  const char* text = nullptr;
  (void)on_board(board, [&](gicube_board& handle) {
    const std::scoped_lock lock(handle.mutex);
    if (!handle.why_invisible.empty()) text = handle.why_invisible.c_str();
  });
  return text;
}

gicube_status gicube_get_counters(gicube_board* board, gicube_counter_list** list) {
  return call([&] {
    checked("list", list) = nullptr;
    *list = new gicube_counter_list{checked_board(board).board.counters()};
  });
}

void gicube_counters_free(gicube_counter_list* list) { delete list; }

size_t gicube_counters_count(const gicube_counter_list* list) {
  return list == nullptr ? 0 : list->counters.list().size();
}

gicube_status gicube_counters_at(const gicube_counter_list* list, size_t index, const char** name, const char** unit,
                                 uint64_t* value) {
  return call([&] {
    const auto& counters = checked("list", list).counters.list();
    gicube::expect(index < counters.size(), "index", fmt::format("less than {}", counters.size()), index);
    if (name != nullptr) *name = counters[index].name.c_str();
    if (unit != nullptr) *unit = counters[index].unit.c_str();
    if (value != nullptr) *value = counters[index].value;
  });
}

gicube_status gicube_counters_value(const gicube_counter_list* list, const char* name, uint64_t* value) {
  return call([&] {
    checked("value", value) = 0;
    const gicube::Counter* counter = checked("list", list).counters.find(&checked("name", name));
    if (counter == nullptr) throw gicube::Unsupported(std::string("the board has no counter ") + name);
    *value = counter->value;
  });
}
}
