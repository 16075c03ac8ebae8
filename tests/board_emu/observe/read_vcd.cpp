#include "read_vcd.h"

#include <sstream>
#include <stdexcept>

namespace gicube::emu {

namespace {

void require(bool right, const std::string& what) {
  if (!right) throw std::runtime_error("value change dump: " + what);
}

class Reader {
 public:
  explicit Reader(const std::string& text) : in_(text) {}

  ReadVcd read() {
    header();
    std::string token;
    bool timed = false;
    while (in_ >> token) {
      if (token == "$dumpvars" || token == "$end") continue;
      if (token[0] == '#') {
        const std::uint64_t time = std::stoull(token.substr(1));
        require(!timed || time > vcd_.end, "time " + token + " does not go on");
        if (!timed) vcd_.begin = time;
        timed = true;
        vcd_.end = time;
        continue;
      }
      require(timed, "a change before the first time");
      change(token);
    }
    return vcd_;
  }

 private:
  std::vector<std::string> until_end() {
    std::vector<std::string> words;
    for (std::string word; in_ >> word && word != "$end";) words.push_back(word);
    return words;
  }

  void header() {
    std::string scope;
    int depth = 0;
    for (std::string token; in_ >> token;) {
      const std::vector<std::string> words = until_end();
      if (token == "$timescale") {
        vcd_.timescale = words.at(0) + ' ' + words.at(1);
      } else if (token == "$scope") {
        require(words.at(0) == "module", "a scope that is no module");
        scope += words.at(1) + '.';
        ++depth;
      } else if (token == "$upscope") {
        scope.erase(scope.find_last_of('.', scope.size() - 2) + 1);
        --depth;
      } else if (token == "$var") {
        const std::string name = scope + words.at(3);
        require(names_.emplace(words.at(2), name).second, "two signals with id " + words.at(2));
        vcd_.bits[name] = static_cast<unsigned>(std::stoul(words.at(1)));
      } else if (token == "$enddefinitions") {
        require(depth == 0, "a scope is open");
        require(!vcd_.timescale.empty(), "no timescale");
        return;
      } else {
        require(token == "$comment", "no such keyword " + token);
      }
    }
    require(false, "no $enddefinitions");
  }

  void change(const std::string& token) {
    std::string value = token.substr(0, 1), id = token.substr(1);
    if (value == "b") {
      value = id;
      require(static_cast<bool>(in_ >> id), "a value without an id");
    }
    const auto name = names_.find(id);
    require(name != names_.end(), "id " + id + " was not declared");
    require(value.size() <= vcd_.bits[name->second], name->second + " gets " + value);
    require(value == "z" || value.find_first_not_of("01") == std::string::npos, "value " + value);
    auto& changes = vcd_.signals[name->second];
    require(changes.empty() || changes.back().value != value, name->second + " does not change to " + value);
    changes.push_back({vcd_.end, value});
  }

  std::istringstream in_;
  std::map<std::string, std::string> names_;
  ReadVcd vcd_;
};

}  // namespace

std::string ReadVcd::at(const std::string& signal, std::uint64_t time) const {
  std::string value = "x";
  for (const Change& change : signals.at(signal)) {
    if (change.time > time) break;
    value = change.value;
  }
  return value;
}

ReadVcd read_vcd(const std::string& text) { return Reader(text).read(); }

}  // namespace gicube::emu
