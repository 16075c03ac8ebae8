#include "observe/trace_file.h"

#include "read_trace.h"
#include "temporary_directory.h"
#include "test.h"

namespace gicube::emu {
namespace {

TEST(TraceFile, WritesTheTraceEventFormat) {
  const reference::TemporaryDirectory folder;
  {
    TraceFile trace(folder.file("t"));
    trace.name_process(2, "host bus");
    trace.name_track({2, 21}, "down");
    trace.slice({2, 21}, "table", 1'234'567, 5'000'000, R"("bytes":4)");
    trace.counter(2, "rays", 2'000'999, 7);
    trace.instant({2, 21}, "power-up", 0);
  }
  EXPECT_EQ(read_text(folder.file("t")),
            R"([
{"ph":"M","name":"process_name","pid":2,"args":{"name":"host bus"}},
{"ph":"M","name":"process_sort_index","pid":2,"args":{"sort_index":2}},
{"ph":"M","name":"thread_name","pid":2,"tid":21,"args":{"name":"down"}},
{"ph":"X","pid":2,"tid":21,"ts":1.234,"dur":3.766,"name":"table","args":{"bytes":4}},
{"ph":"C","pid":2,"ts":2.000,"name":"rays","args":{"value":7}},
{"ph":"i","s":"g","pid":2,"tid":21,"ts":0.000,"name":"power-up"}
]
)");
}

TEST(TraceFile, IsWholeWheneverItIsCompletedAndGoesOnAfterThat) {
  const reference::TemporaryDirectory folder;
  TraceFile trace(folder.file("t"));
  trace.name_process(1, "p");
  trace.name_track({1, 11}, "t");
  trace.complete();
  EXPECT_TRUE(read_trace(read_text(folder.file("t"))).slices.empty());
  for (unsigned i = 0; i < 3; ++i) {
    trace.slice({1, 11}, "s", i * 1000, (i + 1) * 1000, "");
    trace.complete();
    EXPECT_EQ(read_trace(read_text(folder.file("t"))).slices.at("p/t").size(), i + 1);
  }
  EXPECT_EQ(trace.latest(), 3000u);
}

TEST(TraceFile, StreamsWholeRecordsSoThatAKilledBoardLeavesAReadableFile) {
  const reference::TemporaryDirectory folder;
  TraceFile trace(folder.file("t"));
  trace.name_process(1, "p");
  trace.name_track({1, 11}, "t");
  for (unsigned i = 0; i < 20'000; ++i) trace.slice({1, 11}, "a slice", i * 1000, (i + 1) * 1000, "");
  std::string text = read_text(folder.file("t"));  // as it would be found now
  EXPECT_GT(text.size(), 1'000'000u);
  EXPECT_EQ(text.back(), '}');
  EXPECT_GT(read_trace(text + "]").slices.at("p/t").size(), 15'000u);
}

TEST(TraceFile, TouchingSlicesTouchInWholeNanosecondsToo) {
  const reference::TemporaryDirectory folder;
  {
    TraceFile trace(folder.file("t"));
    trace.name_process(1, "p");
    trace.name_track({1, 11}, "t");
    for (unsigned i = 0; i < 100; ++i) trace.slice({1, 11}, "s", i * 7519, (i + 1) * 7519, "");  // 133 MHz
  }
  const auto slices = read_trace(read_text(folder.file("t"))).slices.at("p/t");  // throws if any overlap
  for (std::size_t i = 1; i < slices.size(); ++i) EXPECT_EQ(slices[i].begin_ns, slices[i - 1].end_ns);
}

TEST(TraceFile, ANewOneTakesNoNameThatIsThereAndFollowsNoLink) {
  namespace fs = std::filesystem;
  const reference::TemporaryDirectory folder;
  const std::string target = folder.file("target"), link = folder.file("link"), there = folder.file("there");
  fs::create_symlink(target, link);
  std::ofstream(there) << "mine";
  for (const std::string& name : {link, there}) {
    try {
      const TraceFile trace(name, Creation::kNew);
      FAIL() << name;
    } catch (const std::runtime_error& error) {
      EXPECT_EQ(error.what(), "expected the name of a new file, got " + name);
    }
  }
  EXPECT_FALSE(fs::exists(target));
  EXPECT_EQ(fs::file_size(there), 4u);
  { const TraceFile trace(folder.file("new"), Creation::kNew); }
  EXPECT_GT(fs::file_size(folder.file("new")), 0u);
}

TEST(TraceFile, NamesTheFileThatCannotBeOpened) {
  EXPECT_THROWS(std::runtime_error, "/nowhere/at/all.json", TraceFile trace("/nowhere/at/all.json"));
}

TEST(TraceFile, AFullDiskIsSeen) {
  TraceFile trace("/dev/full");
  EXPECT_TRUE(trace.file().good());
  trace.instant({1, 1}, "i", 0);
  trace.complete();
  EXPECT_FALSE(trace.file().good());
}

}  // namespace
}  // namespace gicube::emu
