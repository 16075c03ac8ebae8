// The header of nearly every test: GoogleTest, the standard library's common headers, and the names of matchers.
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <numbers>

#include "../../script/common_headers.h"

// The statement behind the text throws an Error whose message holds the text.
#define EXPECT_THROWS(Error, text, ...) \
  EXPECT_THAT([&] { __VA_ARGS__; }, testing::ThrowsMessage<Error>(testing::HasSubstr(text)))

namespace gicube {

using testing::AllOf;
using testing::ContainsRegex;
using testing::ElementsAre;
using testing::EndsWith;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;
using testing::StartsWith;
using testing::ThrowsMessage;

// The message of the Error that `call` throws; "none" if it throws none.
template <typename Error, typename Call>
std::string message_of(const Call& call) {
  try {
    call();
  } catch (const Error& error) {
    return error.what();
  }
  return "none";
}

// The bytes of the file; none if it cannot be read.
inline std::string text_of(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

}  // namespace gicube
