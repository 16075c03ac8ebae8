// Light between pairs of elements.
#include <algorithm>

#include "fields.h"

namespace gicube::c_api {
namespace {

Element to_element(const gicube_element& element, std::size_t index) {
  const std::string name = "elements[" + std::to_string(index) + "]";
  if (element.reserved != 0) throw BadArgument(name + ".reserved", "0", std::to_string(element.reserved));
  return {choice(name + ".kind", element.kind, ElementKind::kBox), to_vec3(element.origin), to_vec3(element.u),
          to_vec3(element.v), to_vec3(element.w)};
}

ElementPair to_pair(const gicube_element_pair& pair, std::size_t index) {
  if (pair.reserved != 0) {
    throw BadArgument("pairs[" + std::to_string(index) + "].reserved", "0", std::to_string(pair.reserved));
  }
  return {pair.a, pair.b, pair.id};
}

}  // namespace
}  // namespace gicube::c_api

using namespace gicube::c_api;

extern "C" {

gicube_status gicube_pair_factors(gicube_board* board, const gicube_element* elements, size_t element_count,
                                  const gicube_element_pair* pairs, size_t pair_count,
                                  const gicube_pair_request* request, gicube_progress progress, void* user,
                                  gicube_pair_factor* factors, size_t count) {
  return call([&] {
    gicube_board& handle = checked_board(board);
    checked("elements", elements, element_count);
    checked("pairs", pairs, pair_count);
    check_count("count", count, pair_count);
    checked("factors", factors, count);
    const auto how = read_optional<gicube_pair_request, gicube::PairRequest>("request", request);
    std::vector<gicube::Element> all;
    for (std::size_t i = 0; i < element_count; ++i) all.push_back(to_element(elements[i], i));
    std::vector<gicube::ElementPair> between;
    for (std::size_t i = 0; i < pair_count; ++i) between.push_back(to_pair(pairs[i], i));
    for (const gicube::PairFactor& factor : handle.board.pair_factors(all, between, how, to_progress(progress, user))) {
      *factors++ = {factor.transported, factor.geometric, factor.standard_error, factor.clear ? 1 : 0, 0};
    }
  });
}
}
