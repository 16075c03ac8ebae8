// Serialisation for checkpoints. Each part lists its members once, for saving and for loading, in `void state(Archive&
// archive)`; a record does so in `void state(Archive::Record& record)`. So everything that is saved is also restored.
// The limits of values are those that the code relies on.
//
// The order of the fields is fixed. If a file has another order or an impossible value, loading fails with the field's
// name.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

namespace gicube::emu {
struct TokenLimits;
}

namespace gicube {

// The board cannot continue from this checkpoint. what() states the field, the expected value and the value found.
class CheckpointFault : public std::runtime_error {
 public:
  explicit CheckpointFault(const std::string& what) : std::runtime_error("checkpoint: " + what) {}
  CheckpointFault(const std::string& field, const std::string& expected, const std::string& got)
      : std::runtime_error("checkpoint: " + field + ": expected " + expected + ", got " + got),
        field_(field),
        expected_(expected),
        got_(got) {}

  // Empty if the exception was constructed from one text.
  const std::string& field() const { return field_; }
  const std::string& expected() const { return expected_; }
  const std::string& got() const { return got_; }

 private:
  std::string field_, expected_, got_;
};

class Archive {
 public:
  // One named entry of a checkpoint file.
  struct Field {
    std::string name{};
    std::vector<std::uint64_t> numbers{};
    std::string bytes{};
    std::vector<std::string> texts{};
  };

  explicit Archive(bool loads) : loads_(loads) {}
  Archive(const Archive&) = delete;
  Archive& operator=(const Archive&) = delete;
  virtual ~Archive() = default;

  bool loads() const { return loads_; }
  [[noreturn]] void refuse(std::string_view name, const std::string& expected, const std::string& got) const {
    throw CheckpointFault(prefix_ + std::string(name), expected, got);
  }
  // Checks a loaded value.
  void expect(bool good, std::string_view name, const std::string& expected, std::uint64_t got) const {
    if (!good) refuse(name, expected, std::to_string(got));
  }
  // True while a run of the level is in progress. Parts then also list the rays that they hold.
  bool in_run() const { return in_run_; }
  void set_in_run(bool in_run) { in_run_ = in_run; }
  // Limits for the tokens of a run in progress; null while saving. The object must outlive the loading.
  void set_token_limits(emu::TokenLimits* limits) { token_limits_ = limits; }
  emu::TokenLimits* token_limits() const { return token_limits_; }
  // Upper limit of the clock readings that times() accepts. in_clock() changes it while `work` lists a part that has
  // its own clock.
  std::uint64_t latest() const { return latest_; }
  template <typename Work>
  void in_clock(std::uint64_t latest, const Work& work) {
    const std::uint64_t before = std::exchange(latest_, latest);
    work();
    latest_ = before;
  }
  // Throws if a part is busy between two transactions. Its contents are not saved, so it must be idle.
  void expect_idle(bool idle, const char* part) const {
    if (!idle && !in_run_)
      throw std::logic_error(std::string("checkpoint: ") + part + " is at work between two transactions");
  }

  // Reads or writes the numbers of one field.
  class Record {
   public:
    template <typename... Values>
    void operator()(Values&... values) {
      (put(values), ...);
    }
    template <typename Value>
    void at_most(Value& value, std::type_identity_t<Value> most) {
      number(value, number_of(most));
    }
    // Readings of the part's clock, at most latest(). All ones means no time.
    template <typename... Values>
    void times(Values&... values) {
      (time(values), ...);
    }
    // A list of variable length. When loading, its elements are default-constructed first.
    template <typename List>
    void list(List& values, std::uint64_t most) {
      std::uint64_t count = values.size();
      number(count, most);
      if (archive_.loads_) {
        const std::uint64_t left = numbers_.size() - at_;
        archive_.expect(count <= left, "", "numbers for " + std::to_string(count) + " elements", left);
        values.resize(static_cast<std::size_t>(count));
      }
      for (auto& value : values) put(value);
    }

    bool loads() const { return archive_.loads_; }
    const emu::TokenLimits* token_limits() const { return archive_.token_limits_; }
    // Checks a loaded value.
    void expect(bool good, const std::string& expected, std::uint64_t got) const {
      archive_.expect(good, "", expected, got);
    }

   private:
    friend Archive;
    Record(Archive& archive, std::vector<std::uint64_t>& numbers) : archive_(archive), numbers_(numbers) {}

    template <typename Value>
    void put(Value& value) {
      if constexpr (requires { value.state(*this); }) {
        value.state(*this);
      } else if constexpr (requires { state_of(*this, value); }) {  // a record with a free function state_of()
        state_of(*this, value);
      } else if constexpr (std::is_arithmetic_v<Value> || std::is_enum_v<Value>) {
        number(value, ~std::uint64_t{0});
      } else if constexpr (requires { value.second; }) {
        put(value.first);
        put(value.second);
      } else {  // an array whose size follows from the configuration
        for (auto& each : value) put(each);
      }
    }
    template <typename Value>
    void time(Value& value) {
      if constexpr (std::is_same_v<Value, std::uint64_t>) {
        number(value, ~std::uint64_t{0});
        const bool comes = !archive_.loads_ || value <= archive_.latest_ || value == ~std::uint64_t{0};
        if (!comes) {
          archive_.refuse("",
                          "a time of at most " + std::to_string(archive_.latest_) + " as number " + std::to_string(at_),
                          std::to_string(value));
        }
      } else {
        for (auto& each : value) time(each);
      }
    }
    template <typename Value>
    static std::uint64_t number_of(Value value) {
      if constexpr (std::is_same_v<Value, double>) {
        return std::bit_cast<std::uint64_t>(value);
      } else if constexpr (std::is_same_v<Value, float>) {
        return std::bit_cast<std::uint32_t>(value);
      } else {
        return static_cast<std::uint64_t>(value);
      }
    }
    template <typename Value>
    static Value value_of(std::uint64_t number) {
      if constexpr (std::is_same_v<Value, double>) {
        return std::bit_cast<double>(number);
      } else if constexpr (std::is_same_v<Value, float>) {
        return std::bit_cast<float>(static_cast<std::uint32_t>(number));
      } else {
        return static_cast<Value>(number);
      }
    }
    template <typename Value>
    void number(Value& value, std::uint64_t most) {
      if (!archive_.loads_) return numbers_.push_back(number_of(value));
      archive_.expect(at_ < numbers_.size(), "", "more numbers", numbers_.size());
      const std::uint64_t got = numbers_[at_++];
      const auto read = value_of<Value>(got);
      const bool fits = got <= most && number_of(read) == got;
      if (!fits) {
        const std::string bound =
            most == ~std::uint64_t{0} ? std::to_string(8 * sizeof(Value)) + " bits" : "at most " + std::to_string(most);
        archive_.refuse("", bound + " as number " + std::to_string(at_), std::to_string(got));
      }
      value = read;
    }

    Archive& archive_;
    std::vector<std::uint64_t>& numbers_;
    std::size_t at_ = 0;
  };

  // Lists a part with its fields, or one field: a number, a record, or an array whose size follows from the
  // configuration.
  template <typename Value>
  void operator()(std::string_view name, Value& value) {
    if constexpr (requires { value.state(*this); }) {
      within(name, [&] { value.state(*this); });
    } else {
      field(name, [&](Record& record) { record(value); });
    }
  }
  template <typename Value>
  void at_most(std::string_view name, Value& value, std::type_identity_t<Value> most) {
    field(name, [&](Record& record) { record.at_most(value, most); });
  }
  template <typename List>
  void list(std::string_view name, List& values, std::uint64_t most = std::numeric_limits<std::uint32_t>::max()) {
    field(name, [&](Record& record) { record.list(values, most); });
  }
  // All numbers of a field, without interpretation.
  void numbers(std::string_view name, std::vector<std::uint64_t>& numbers) {
    Field field{.name = prefix_ + std::string(name), .numbers = numbers};
    exchange(field);
    numbers = std::move(field.numbers);
  }
  // Lists parts, or pointers to parts. The index is appended to the name.
  template <typename Parts>
  void parts(std::string_view name, Parts& parts) {
    std::size_t number = 0;
    for (auto& part : parts) {
      within(std::string(name) + std::to_string(number++), [&] {
        if constexpr (requires { part->state(*this); }) {
          part->state(*this);
        } else {
          part.state(*this);
        }
      });
    }
  }
  void bytes(std::string_view name, std::vector<std::uint8_t>& bytes, std::uint64_t least, std::uint64_t most) {
    Field field{.name = prefix_ + std::string(name)};
    if (!loads_) field.bytes.assign(bytes.begin(), bytes.end());
    exchange(field);
    if (!loads_) return;
    const bool fits = field.bytes.size() >= least && field.bytes.size() <= most;
    const std::string range = (least == most ? "" : std::to_string(least) + " to ") + std::to_string(most) + " bytes";
    expect(fits, name, range, field.bytes.size());
    bytes.assign(field.bytes.begin(), field.bytes.end());
  }
  void texts(std::string_view name, std::vector<std::string>& texts) {
    Field field{.name = prefix_ + std::string(name), .texts = texts};
    exchange(field);
    texts = std::move(field.texts);
  }
  template <typename List>
  void field(std::string_view name, const List& list) {
    within(
        name,
        [&] {
          Field field{.name = prefix_};
          if (loads_) exchange(field);
          Record record(*this, field.numbers);
          list(record);
          if (loads_) {
            expect(record.at_ == field.numbers.size(), "", std::to_string(record.at_) + " numbers",
                   field.numbers.size());
          } else {
            exchange(field);
          }
        },
        "");
  }
  template <typename Work>
  void within(std::string_view name, const Work& work, std::string_view after = ".") {
    const std::size_t before = prefix_.size();
    prefix_.append(name).append(after);
    work();
    prefix_.resize(before);
  }

 private:
  // Saving: appends the field. Loading: reads the next field, whose name must match.
  virtual void exchange(Field& field) = 0;

  const bool loads_;
  bool in_run_ = false;
  std::uint64_t latest_ = std::uint64_t{1} << 54;  // chosen: above any simulated time, low enough for products
  emu::TokenLimits* token_limits_ = nullptr;
  std::string prefix_;
};

// Serialises one field into a vector of numbers.
class NumbersArchive final : public Archive {
 public:
  NumbersArchive(bool loads, std::vector<std::uint64_t>& numbers) : Archive(loads), numbers_(numbers) {}

 private:
  void exchange(Field& field) override {
    if (loads()) {
      field.numbers = numbers_;
    } else {
      numbers_ = std::move(field.numbers);
    }
  }

  std::vector<std::uint64_t>& numbers_;
};

}  // namespace gicube
