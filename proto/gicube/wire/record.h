// Records of the wire protocol. A record lists its fields once, in the order of their bytes or bits. Its size, encode()
// and decode() follow from the list. README.md defines the bytes.
//
//   struct Pair {
//     std::uint32_t a = 0, b = 0, id = 0;
//     constexpr void fields(auto&& list) { list(a, b, id); }   // or bits(): list(16, u, v); list(24, position);
//   };
//
// A listed value that is not a member, such as an opcode or Reserved<4>{}, is written, and skipped on reading.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include "gicube/wire/bytes.h"

namespace gicube::wire {

template <std::size_t Bytes>
using Reserved = std::array<std::uint8_t, Bytes>;

template <typename T>
concept ByteFields = requires(T record) {
  record.fields([](auto&&...) {});
};
template <typename T>
concept BitFields = requires(T record) {
  record.bits([](unsigned, auto&&...) {});
};
template <typename T>
concept Record = ByteFields<T> || BitFields<T>;

namespace detail {

template <typename T>
concept Array = requires {
  std::tuple_size<T>::value;
};

template <typename T>
constexpr std::size_t count_of() {
  if constexpr (Array<T>) {
    return std::tuple_size_v<T>;
  } else {
    return 1;
  }
}

// Calls take() for the value, or for each element of an array.
template <typename T>
constexpr void for_each(T& value, const auto& take) {
  if constexpr (Array<T>) {
    std::apply([&](auto&... each) { (take(each), ...); }, value);
  } else {
    take(value);
  }
}

}  // namespace detail

// Size of a record or a field in bytes.
template <typename T>
constexpr std::size_t bytes_of() {
  std::size_t size = 0;
  if constexpr (ByteFields<T>) {
    T{}.fields([&size]<typename... Field>(Field&&...) { size = (bytes_of<std::remove_cvref_t<Field>>() + ...); });
  } else if constexpr (BitFields<T>) {
    T{}.bits([&size]<typename... Field>(unsigned width, Field&&...) {
      size += width * (detail::count_of<std::remove_cvref_t<Field>>() + ...);
    });
    size /= 8;
  } else {
    size = sizeof(T);
  }
  return size;
}

// Writes the first bytes_of<T>() bytes of `out`.
template <Record T>
constexpr void encode(T record, std::span<std::uint8_t> out) {
  std::size_t at = 0;
  if constexpr (ByteFields<T>) {
    const auto put = [&](auto& field) {
      using Field = std::remove_cvref_t<decltype(field)>;
      if constexpr (Record<Field>) {
        encode(field, out.subspan(at));
      } else {
        store(out, at, field);
      }
      at += bytes_of<Field>();
    };
    record.fields([&](auto&&... fields) { (detail::for_each(fields, put), ...); });
  } else {
    BitRecord<(bytes_of<T>() + 7) / 8> packed;
    const auto put = [&](unsigned width) {
      return [&, width](auto field) {
        packed.put(static_cast<unsigned>(std::exchange(at, at + width)), width, static_cast<std::uint32_t>(field));
      };
    };
    record.bits([&](unsigned width, auto&&... fields) { (detail::for_each(fields, put(width)), ...); });
    for (std::size_t i = 0; i < bytes_of<T>() / 4; ++i) {
      store(out, 4 * i, static_cast<std::uint32_t>(packed.words[i / 2] >> (32 * (i % 2))));
    }
  }
}

// Reads the first bytes_of<T>() bytes of `in`, which must be that long. The values are not checked; their users must do
// that.
template <Record T>
constexpr T decode(std::span<const std::uint8_t> in) {
  T record;
  std::size_t at = 0;
  if constexpr (ByteFields<T>) {
    const auto get = [&](auto& field) {
      using Field = std::remove_cvref_t<decltype(field)>;
      if constexpr (Record<Field>) {
        field = decode<Field>(in.subspan(at));
      } else {
        field = load<Field>(in, at);
      }
      at += bytes_of<Field>();
    };
    record.fields([&](auto&&... fields) { (detail::for_each(fields, get), ...); });
  } else {
    BitRecord<(bytes_of<T>() + 7) / 8> packed;
    for (std::size_t i = 0; i < bytes_of<T>() / 4; ++i) {
      packed.words[i / 2] |= std::uint64_t{load<std::uint32_t>(in, 4 * i)} << (32 * (i % 2));
    }
    const auto get = [&](unsigned width) {
      return [&, width](auto& field) {
        using Field = std::remove_cvref_t<decltype(field)>;
        const std::uint32_t bits = packed.get(static_cast<unsigned>(std::exchange(at, at + width)), width);
        field =
            static_cast<Field>(std::is_signed_v<Field> ? static_cast<std::uint32_t>(sign_extend(bits, width)) : bits);
      };
    };
    record.bits([&](unsigned width, auto&&... fields) { (detail::for_each(fields, get(width)), ...); });
  }
  return record;
}

// Appends the record's bytes.
template <Record T>
void append(std::vector<std::uint8_t>& bytes, const T& record) {
  bytes.resize(bytes.size() + bytes_of<T>());
  encode(record, std::span(bytes).last(bytes_of<T>()));
}

template <Record T>
std::vector<std::uint8_t> encoded(const T& record) {
  std::vector<std::uint8_t> bytes;
  append(bytes, record);
  return bytes;
}

}  // namespace gicube::wire
