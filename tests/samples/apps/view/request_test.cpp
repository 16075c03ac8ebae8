// Messages of a page: their meaning, and those that are refused.
#include "view/request.h"

#include "gicube/scene/error.h"
#include "scene/names.h"
#include "test.h"

namespace gicube::samples::view {
namespace {

using Kind = Request::Kind;

std::string fault_of(const std::string& text) {
  return message_of<InputError>([&] { parse_request(text); });
}

TEST(ViewRequest, APictureHasItsIdItsHasteAndItsSettings) {
  const Request request =
      parse_request(R"({"do":"picture","id":7,"moving":true,"settings":{"eye":"1,2,3","asic.processors":"8"}})");
  EXPECT_EQ(request.kind, Kind::kPicture);
  EXPECT_EQ(request.id, 7u);
  EXPECT_TRUE(request.on);
  EXPECT_EQ(request.settings, (Settings{{"eye", "1,2,3"}, {"asic.processors", "8"}}));
  EXPECT_EQ(request.projection, Request::Projection::kNone);
  const char* const mean = R"({"do":"picture","id":7,"moving":false,"projection":"mean","settings":{}})";
  EXPECT_EQ(parse_request(mean).projection, Request::Projection::kMean);
}

TEST(ViewRequest, EveryKindOfTheProtocolIsTaken) {
  EXPECT_EQ(parse_request(R"({"do":"histogram"})").kind, Kind::kHistogram);
  EXPECT_EQ(parse_request(R"({"do":"board"})").kind, Kind::kBoard);
  EXPECT_TRUE(parse_request(R"({"do":"machine","on":true})").on);
  const Request slice = parse_request(R"({"do":"slice","id":1,"axis":"y","at":5})");
  EXPECT_EQ(slice.axis, 1);
  EXPECT_EQ(slice.at, 5);
  EXPECT_EQ(parse_request(R"({"do":"open","names":["a.nhdr","a.raw"]})").names.size(), 2u);
  const Request both = parse_request(R"({"do":"compare","id":1,"settings":{"step":"1"},"other":{"step":"2"}})");
  EXPECT_EQ(both.settings.at("step"), "1");
  EXPECT_EQ(both.other.at("step"), "2");
}

TEST(ViewRequest, WhatIsNoMessageIsRefusedByItsFault) {
  EXPECT_EQ(fault_of("[]"), "message: expected a JSON object, got something else");
  EXPECT_EQ(fault_of(""), "message: expected a JSON object, got something else");
  EXPECT_EQ(fault_of(R"({"id":1})"), "do: expected a text, got none");
  EXPECT_EQ(fault_of(R"({"do":"dance"})"), "do: expected a request of protocol.h, got \"dance\"");
  EXPECT_EQ(fault_of(R"({"do":"picture","id":-1,"moving":true,"settings":{}})"),
            "id: expected a whole number, got number");
  EXPECT_EQ(fault_of(R"({"do":"picture","id":1,"moving":1,"settings":{}})"),
            "moving: expected true or false, got number");
  EXPECT_EQ(fault_of(R"({"do":"picture","id":1,"moving":true,"settings":{"step":1}})"),
            "step: expected a text, got number");
  EXPECT_EQ(fault_of(R"({"do":"picture","id":1,"moving":true,"projection":"min","settings":{}})"),
            "projection: expected max or mean, got \"min\"");
  EXPECT_EQ(fault_of(R"({"do":"slice","id":1,"axis":"xy","at":0})"), "axis: expected x, y or z, got \"xy\"");
  EXPECT_EQ(fault_of(R"({"do":"slice","id":1,"axis":"x","at":4294967296})"),
            "at: expected at most 2147483647, got 4294967296");
  EXPECT_EQ(fault_of(R"({"do":"open","names":[]})"), "names: expected 1 to 8192 names, got 0");
  EXPECT_EQ(fault_of(R"({"do":"open","names":["a/b"]})"), "names: expected names of posted files, got something else");
}

TEST(ViewRequest, IdsEndWhereJavaScriptCountsExactly) {
  const auto with = [](const std::string& id) { return R"({"do":"slice","axis":"x","at":0,"id":)" + id + "}"; };
  EXPECT_EQ(parse_request(with("9007199254740992")).id, 9007199254740992u);
  EXPECT_EQ(fault_of(with("9007199254740993")), "id: expected at most 9007199254740992, got 9007199254740993");
}

TEST(ViewRequest, ManySettingsAreTooMany) {
  std::string text = R"({"do":"picture","id":1,"moving":true,"settings":{"s0":"")";
  for (int i = 1; i < 64; ++i) text += ",\"s" + std::to_string(i) + "\":\"\"";
  EXPECT_EQ(fault_of(text + "}}"), "none");
  EXPECT_EQ(fault_of(text + ",\"one\":\"\"}}"), "settings: expected at most 64 settings, got 65");
}

TEST(ViewFileName, HasNoSlashNoLeadingDotNoControlCharacterAndAnEnd) {
  EXPECT_TRUE(is_file_name("head (2).nii.gz"));
  EXPECT_TRUE(is_file_name("Schädel.nrrd"));
  EXPECT_TRUE(is_file_name(std::string(200, 'a')));
  for (const std::string& name :
       {std::string(), std::string("."), std::string(".."), std::string(".hidden"), std::string("a/b"),
        std::string("a\nb"), std::string("a\0b", 3), std::string("a\x7f"), std::string(201, 'a')}) {
    EXPECT_FALSE(is_file_name(name)) << name;
  }
}

}  // namespace
}  // namespace gicube::samples::view
