#include "gicube/wire/counter_list.h"

#include <rapidcheck/gtest.h>

#include "hex.h"
#include "records.h"
#include "test.h"

namespace gicube::wire {
namespace {

std::vector<Counter> any_counters() {
  std::vector<Counter> counters(*rc::gen::inRange<std::size_t>(0, 6));
  for (Counter& counter : counters) {
    counter.name = *rc::gen::container<std::string>(*rc::gen::inRange<std::size_t>(0, 256), rc::gen::arbitrary<char>());
    counter.unit = *rc::gen::container<std::string>(*rc::gen::inRange<std::size_t>(0, 8), rc::gen::arbitrary<char>());
    counter.value = any_bits<std::uint64_t>(64);
  }
  return counters;
}

TEST(CounterList, HasTheBytesThatItsTableSays) {
  const std::vector<Counter> counters{{"rays", "ray", 0x0102}};
  // One counter; 4 "rays"; 3 "ray"; the value.
  EXPECT_EQ(to_hex(encode(counters)), "01 00 00 00 04 72 61 79 73 03 72 61 79 02 01 00 00 00 00 00 00");
}

RC_GTEST_PROP(CounterList, ComesBackAsItWas, ()) {
  const std::vector<Counter> counters = any_counters();
  RC_ASSERT(decode_counters(encode(counters)) == counters);
}

RC_GTEST_PROP(CounterList, CutShortIsRefusedAtEveryLength, ()) {
  const std::vector<std::uint8_t> bytes = encode(any_counters());
  for (std::size_t length = 0; length < bytes.size(); ++length) {
    RC_ASSERT(!decode_counters(std::span(bytes).first(length)).has_value());
  }
}

TEST(CounterList, ThatLiesAboutItsCountIsRefused) {
  std::vector<std::uint8_t> bytes = encode(std::vector<Counter>{{"rays", "ray", 1}});
  store(std::span(bytes), 0, std::uint32_t{0xFFFF'FFFF});
  EXPECT_EQ(decode_counters(bytes), std::nullopt);
}

RC_GTEST_PROP(CounterList, OfGarbageIsReadWithinItsBounds, (const std::vector<std::uint8_t>& garbage)) {
  // Whatever is found must have stood there: four bytes of count, then at least ten a counter.
  const auto counters = decode_counters(garbage);
  if (counters) RC_ASSERT(4 + 10 * counters->size() <= garbage.size());
}

TEST(CounterList, KeepsTheFirst255BytesOfALongerName) {
  const std::vector<Counter> counters{{std::string(300, 'n'), "ray", 7}};
  const auto decoded = decode_counters(encode(counters));
  ASSERT_TRUE(decoded.has_value());
  EXPECT_EQ(decoded->at(0).name.size(), 255u);
  EXPECT_EQ(decoded->at(0).value, 7u);
}

}  // namespace
}  // namespace gicube::wire
