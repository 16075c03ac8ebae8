// Opening, what the board is, simulated time, counters.
#include <memory>

#include "fields.h"

struct GICUBE_HIDDEN gicube_counter_list {
  std::vector<gicube::Counter> counters;
};

namespace gicube::c_api {
namespace {

OpenOptions to_options(const gicube_open_options* given) {
  if (given == nullptr) return {};
  gicube_open_options record;
  auto options = read_fields<gicube_open_options, OpenOptions>("options", given, record);
  if (record.capture != nullptr) options.capture = record.capture;
  return options;
}

gicube_board_info to_c(const BoardInfo& info) {
  gicube_board_info record{};
  record.protocol_major = info.protocol_major;
  record.protocol_minor = info.protocol_minor;
  record.fidelity = static_cast<std::int32_t>(info.fidelity);
  record.processors = info.processors;
  record.block_voxels = info.block_voxels;
  record.max_volume_voxels = info.max_volume_voxels;
  record.queue_rays = info.queue_rays;
  record.config_hash = info.config_hash;
  record.core_khz = info.core_khz;
  record.vendor_id = info.vendor_id;
  record.device_id = info.device_id;
  record.wide = info.wide;
  record.agp = info.agp;
  record.host_rays = info.host_rays;
  return record;
}

}  // namespace
}  // namespace gicube::c_api

using namespace gicube::c_api;

extern "C" {

gicube_status gicube_open(const char* uri, const gicube_open_options* options, gicube_board** board) {
  return call([&] {
    checked("board", board) = nullptr;
    checked("uri", uri);
    *board = new gicube_board(gicube::Board::open(uri, to_options(options)));
  });
}

gicube_status gicube_reopen(gicube_board* board, gicube_reopened* reopened) {
  return call([&] {
    gicube_board& handle = checked_board(board);
    const gicube::Reopened found = handle.board.reopen();
    if (!found.resumed) {  // the framebuffer is gone
      const std::scoped_lock lock(handle.mutex);
      handle.framebuffer = {};
    }
    if (reopened != nullptr) *reopened = {found.resumed, found.volume};
  });
}

void gicube_close(gicube_board* board) { delete board; }

gicube_status gicube_get_info(gicube_board* board, gicube_board_info* info) {
  return call([&] { write_record("info", info, to_c(checked_board(board).board.info())); });
}

gicube_status gicube_now(gicube_board* board, uint64_t* now_ps) {
  return call([&] { checked("now_ps", now_ps) = checked_board(board).board.now(); });
}

gicube_status gicube_host_compute(gicube_board* board, uint64_t duration_ps) {
  return call([&] { checked_board(board).board.host_compute(duration_ps); });
}

gicube_status gicube_set_time_limit(gicube_board* board, uint64_t limit_ps) {
  return call([&] { checked_board(board).board.set_time_limit(limit_ps); });
}

gicube_status gicube_get_counters(gicube_board* board, gicube_counter_list** list) {
  return call([&] {
    checked("list", list) = nullptr;
    *list = new gicube_counter_list{checked_board(board).board.counters().list()};
  });
}

void gicube_counters_free(gicube_counter_list* list) { delete list; }

size_t gicube_counters_count(const gicube_counter_list* list) { return list == nullptr ? 0 : list->counters.size(); }

gicube_status gicube_counters_at(const gicube_counter_list* list, size_t index, const char** name, const char** unit,
                                 uint64_t* value) {
  return call([&] {
    const auto& counters = checked("list", list).counters;
    if (index >= counters.size()) {
      throw gicube::BadArgument("index", "less than " + std::to_string(counters.size()), std::to_string(index));
    }
    if (name != nullptr) *name = counters[index].name.c_str();
    if (unit != nullptr) *unit = counters[index].unit.c_str();
    if (value != nullptr) *value = counters[index].value;
  });
}

gicube_status gicube_counters_value(const gicube_counter_list* list, const char* name, uint64_t* value) {
  return call([&] {
    checked("value", value) = 0;
    const std::string wanted = &checked("name", name);
    for (const gicube::Counter& counter : checked("list", list).counters) {
      if (counter.name != wanted) continue;
      *value = counter.value;
      return;
    }
    throw gicube::Unsupported("this board keeps no counter " + wanted);
  });
}
}
