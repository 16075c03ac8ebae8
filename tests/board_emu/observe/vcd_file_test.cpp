#include "observe/vcd_file.h"

#include "read_trace.h"
#include "read_vcd.h"
#include "temporary_directory.h"
#include "test.h"

namespace gicube::emu {
namespace {

TEST(VcdFile, WritesIeee1364) {
  const reference::TemporaryDirectory folder;
  {
    VcdFile vcd(folder.file("v"));
    vcd.comment("a tiny one");
    vcd.timescale(4);
    vcd.open_scope("board");
    const auto busy = vcd.declare("busy", 1);
    vcd.open_scope("part");
    const auto count = vcd.declare("count", 8);
    vcd.close_scope();
    vcd.close_scope();
    vcd.begin(7);
    vcd.set(busy, 0);
    vcd.set(count, std::nullopt);
    vcd.time(8);
    vcd.set(busy, 0);
    vcd.time(9);
    vcd.set(busy, 1);
    vcd.set(count, 5);
    vcd.time(12);
    vcd.set(count, 0);
    vcd.end(20);
  }
  EXPECT_EQ(read_text(folder.file("v")),
            "$comment a tiny one $end\n"
            "$timescale 10 ns $end\n"
            "$scope module board $end\n"
            "$var wire 1 ! busy $end\n"
            "$scope module part $end\n"
            "$var wire 8 \" count [7:0] $end\n"
            "$upscope $end\n"
            "$upscope $end\n"
            "$enddefinitions $end\n"
            "#7\n"
            "$dumpvars\n"
            "0!\n"
            "bz \"\n"
            "$end\n"
            "#9\n"
            "1!\n"
            "b101 \"\n"
            "#12\n"
            "b0 \"\n"
            "#20\n");
}

TEST(VcdFile, ManySignalsHaveIdsOfTheirOwn) {
  const reference::TemporaryDirectory folder;
  {
    VcdFile vcd(folder.file("v"));
    vcd.timescale(0);
    vcd.open_scope("s");
    for (int i = 0; i < 9500; ++i) vcd.declare(std::to_string(i), 1);
    vcd.close_scope();
    vcd.begin(0);
    for (VcdFile::Signal i = 0; i < 9500; ++i) vcd.set(i, i % 3 == 0 ? 1 : 0);
    vcd.end(1);
  }
  const ReadVcd read = read_vcd(read_text(folder.file("v")));
  EXPECT_EQ(read.signals.size(), 9500u);
  EXPECT_EQ(read.timescale, "1 ps");
  for (int i = 0; i < 9500; ++i) EXPECT_EQ(read.at("s." + std::to_string(i), 0), i % 3 == 0 ? "1" : "0");
}

TEST(VcdFile, NamesTheFileThatCannotBeOpened) { EXPECT_THROW(VcdFile("/nowhere/v.vcd"), std::runtime_error); }

}  // namespace
}  // namespace gicube::emu
