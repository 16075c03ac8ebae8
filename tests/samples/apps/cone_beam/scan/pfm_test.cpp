#include "cone_beam/scan/description.h"

#include "gicube/scene/error.h"
#include "temporary_directory.h"
#include "test.h"

namespace gicube::samples {
namespace {

class Pfm : public testing::Test {
 protected:
  std::string written(const std::string& bytes) const {
    std::ofstream(folder_.file("a.pfm"), std::ios::binary) << bytes;
    return folder_.file("a.pfm");
  }
  std::string error_of(const std::string& bytes) const {
    return message_of<FileError>([&] { read_pfm(written(bytes)); });
  }

  const reference::TemporaryDirectory folder_;
};

TEST_F(Pfm, ComesBackAsItWasWritten) {
  const std::vector<float> values{0, -1.5F, 3e30F, 4, 5, 6};
  const Stack map = read_pfm(write_stack({3, 2, values, false}, folder_.file("b.pfm")).at(0));
  EXPECT_EQ(map.columns, 3);
  EXPECT_EQ(map.rows, 2);
  EXPECT_EQ(map.values, values);
}

TEST_F(Pfm, IsBigEndianWithAPositiveScale) {
  const Stack map = read_pfm(written(std::string("Pf 2 1 1.0\n\x3f\x80\x00\x00\xc0\x00\x00\x00", 19)));
  EXPECT_THAT(map.values, ElementsAre(1, -2));
}

TEST_F(Pfm, KeepsTheFilesOrderOfRows) {
  const Stack map = read_pfm(written(std::string("Pf\n1 2\n-1\n\x00\x00\x80\x3f\x00\x00\x00\x40", 18)));
  EXPECT_THAT(map.values, ElementsAre(1, 2));
}

TEST_F(Pfm, IsRefusedWithTheFieldThatIsWrong) {
  EXPECT_THAT(error_of("PF\n1 1\n-1\nabcdabcdabcd"), HasSubstr("header: expected \"Pf\""));
  EXPECT_THAT(error_of("Pf\n1"), HasSubstr("header: expected"));
  EXPECT_THAT(error_of("Pf\n1 1\n0\nabcd"), HasSubstr("scale: expected a number but 0, got 0"));
  EXPECT_THAT(error_of("Pf\n0 1\n-1\nabcd"), HasSubstr("size: expected"));
  EXPECT_THAT(error_of("Pf\n1 1\n-1\nabc"), HasSubstr("expected"));
  EXPECT_THAT(error_of("Pf\n1 1\n-1\nabcdef"), HasSubstr("expected"));
  EXPECT_THAT(error_of("Pf\n99999 99999\n-1\nabcd"), HasSubstr("size: expected"));
}

}  // namespace
}  // namespace gicube::samples
