// Runs a part of the board and its description in SystemVerilog (board_emu/rtl) side by side, and compares all
// registers of the part in every cycle. The part lists its registers itself, as for a checkpoint.
#pragma once

#include <verilated.h>
#include <verilated_sym_props.h>

#include <type_traits>

#include "asic/sim/fifo.h"
#include "gicube/archive.h"
#include "test.h"
#include "words/words.h"

namespace gicube::emu::lockstep {

// Cycles of a test: 10^6 where GICUBE_ALL_SEEDS is set, as script/check does, else a twentieth.
inline Cycle cycles() { return std::getenv("GICUBE_ALL_SEEDS") != nullptr ? 1'000'000 : 50'000; }

using Numbers = std::vector<std::uint64_t>;

// The registers of a part, by name.
class Registers final : public Archive {
 public:
  // Lists a copy, because listing may bring deferred work up to date; or the part itself, where std::ref() says that
  // it does not.
  template <typename Part>
  explicit Registers(Part part) : Archive(false) {
    set_in_run(true);
    static_cast<std::unwrap_reference_t<Part>&>(part).state(*this);
  }

  const Numbers& operator[](const std::string& name) const {
    static const Numbers kNone;
    const auto field = fields_.find(name);
    return field == fields_.end() ? kNone : field->second;
  }
  std::uint64_t number(const std::string& name) const { return fields_.at(name).at(0); }

 private:
  void exchange(Field& field) override { fields_[field.name] = std::move(field.numbers); }

  std::map<std::string, Numbers> fields_;
};

// `count` <= 64 bits of a verilated vector of any width.
inline std::uint64_t bits_at(const void* vector, std::size_t first, std::size_t count) {
  const auto* const bytes = static_cast<const std::uint8_t*>(vector) + first / 8;
  const std::size_t in_byte = first % 8, used = (in_byte + count + 7) / 8;  // 9 at most
  std::uint64_t low = 0;
  std::memcpy(&low, bytes, std::min<std::size_t>(used, 8));
  std::uint64_t out = low >> in_byte;
  if (used > 8) out |= std::uint64_t{bytes[8]} << (64 - in_byte);
  return count == 64 ? out : out & ((std::uint64_t{1} << count) - 1);
}
inline void put_at(void* vector, std::size_t first, std::size_t count, std::uint64_t value) {
  auto* const bytes = static_cast<std::uint8_t*>(vector);
  for (std::size_t i = 0; i < count;) {
    const std::size_t at = first + i, in_byte = at % 8, some = std::min<std::size_t>(8 - in_byte, count - i);
    const unsigned mask = ((1u << some) - 1) << in_byte;
    bytes[at / 8] =
        static_cast<std::uint8_t>((bytes[at / 8] & ~mask) | (static_cast<unsigned>(value >> i) << in_byte & mask));
    i += some;
  }
}
static_assert(std::endian::native == std::endian::little, "words of a verilated vector lie from the lowest byte up");

// Ports of a verilated module.
template <typename Port>
std::uint64_t bits(const Port& port, std::size_t first, std::size_t count) {
  return bits_at(&port, first, count);
}
template <typename Port>
void put(Port& port, std::size_t first, std::size_t count, std::uint64_t value) {
  put_at(&port, first, count, value);
}

// A register in a verilated module.
class Register {
 public:
  Register() = default;
  explicit Register(const VerilatedVar& variable)
      : words_(static_cast<const std::uint8_t*>(variable.datap())),
        stride_(variable.entSize()),
        width_(static_cast<std::size_t>(variable.packed().elements())) {}

  std::uint64_t operator()() const { return bits_at(words_, 0, width_); }
  std::uint64_t operator()(std::size_t first, std::size_t count) const { return bits_at(words_, first, count); }
  // Entry `i` of a memory.
  const std::uint8_t* entry(std::size_t i) const { return words_ + i * stride_; }
  std::uint64_t of_entry(std::size_t i) const { return bits_at(entry(i), 0, width_); }

 private:
  const std::uint8_t* words_ = nullptr;
  std::size_t stride_ = 0, width_ = 0;
};

// A verilated module. Some have neither clock nor reset.
template <typename Model>
class Clocked {
 public:
  // `top`: name of the module.
  explicit Clocked(const std::string& top) : top_(top) {
    if constexpr (requires { model_.rst; }) {
      model_.rst = 1;
      cycle();
      cycle();
      model_.rst = 0;
    }
    settle();
  }
  ~Clocked() { model_.final(); }

  Model* operator->() { return &model_; }
  // By its path below the module: "ranks.selected", "gen_queue[3].one.head".
  Register find(const std::string& path) const {
    std::string full = "TOP." + top_ + ".";
    for (const char letter : path) {
      letter == '[' ? full += "__BRA__" : letter == ']' ? full += "__KET__" : full += letter;
    }
    const std::size_t dot = full.rfind('.');
    const VerilatedScope* const scope = context_.scopeFind(full.substr(0, dot).c_str());
    const VerilatedVar* const found = scope == nullptr ? nullptr : scope->varFind(full.substr(dot + 1).c_str());
    if (found == nullptr) throw std::logic_error("no register " + path);
    return Register(*found);
  }
  // Lets the outputs follow the inputs within a cycle.
  void settle() {
    if constexpr (requires { model_.clk; }) model_.clk = 0;
    model_.eval();
  }
  // The clock edge that ends the cycle.
  void cycle() {
    settle();
    if constexpr (requires { model_.clk; }) model_.clk = 1;
    model_.eval();
  }

 private:
  std::string top_;
  VerilatedContext context_;
  Model model_{&context_, "TOP"};
};

inline bool same(std::uint32_t a, std::uint32_t b) { return a == b; }
inline bool same(const RayToken& a, const RayToken& b) {
  return a.ray == b.ray && a.queue == b.queue && a.contribution == b.contribution && a.processor == b.processor &&
         a.state == b.state && a.has_reserved_slot == b.has_reserved_slot;
}

// One FIFO at the part and one at its description.
template <typename T>
struct Twin {
  explicit Twin(std::size_t capacity = 2) : part(capacity), rtl(capacity) {}

  bool can_push(Cycle now) const { return part.can_push(now); }
  bool can_pop(Cycle now) const { return part.can_pop(now); }
  void push(Cycle now, const T& item) {
    part.push(now, item);
    rtl.push(now, item);
  }
  T pop(Cycle now) {
    rtl.pop(now);
    return part.pop(now);
  }
  // Whether both hold the same, and were pushed and popped in the same cycles.
  bool agrees() const {
    if (part.size() != rtl.size() || part.clock().push != rtl.clock().push || part.clock().pop != rtl.clock().pop)
      return false;
    for (std::size_t i = 0; i < part.size(); ++i) {
      if (!same(part[i], rtl[i])) return false;
    }
    return true;
  }

  Fifo<T> part, rtl;
};

// Random numbers of a test; probabilities change every few hundred cycles, so that parts fill up, run empty and stall.
class Chance {
 public:
  explicit Chance(unsigned seed, std::size_t kinds) : random_(seed), percent_(kinds, 50) {}

  void next_cycle(Cycle now) {
    if (now % 256 != 0) return;
    for (unsigned& percent : percent_) {
      constexpr std::array kLevels{0u, 5u, 20u, 50u, 80u, 100u};
      percent = kLevels[below(kLevels.size())];
    }
  }
  bool happens(std::size_t kind) { return below(100) < percent_[kind]; }
  std::uint32_t below(std::size_t limit) { return static_cast<std::uint32_t>(random_() % limit); }
  std::uint64_t word() { return std::uint64_t{random_()} << 32 | random_(); }

 private:
  std::mt19937 random_;
  std::vector<unsigned> percent_;
};

}  // namespace gicube::emu::lockstep
