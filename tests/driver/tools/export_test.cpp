// gicube-smi export, read as Prometheus reads it: the text format's grammar, and the rules that its `promtool check
// metrics` holds.
#include <csignal>
#include <regex>

#include <boost/asio/ip/tcp.hpp>

#include "board_process.h"
#include "gicube/board.h"
#include "own_registry.h"
#include "run_program.h"
#include "temporary_directory.h"
#include "test.h"

namespace gicube::tools_test {
namespace {

using reference::OwnRegistry;
using system_test::BoardProcess;
using testing::Not;

class Exporter {
 public:
  Exporter() : process_({"export", "--listen", "127.0.0.1:0"}, -1, GICUBE_BIN_DIR "/gicube-smi") {
    const std::string line = process_.read_line();
    std::smatch port;
    if (!std::regex_search(line, port, std::regex("http://127\\.0\\.0\\.1:([0-9]+)/metrics$"))) {
      throw std::runtime_error("no exporter: " + line + process_.read_errors());
    }
    port_ = port[1];
  }

  // Head and body of the answer.
  std::pair<std::string, std::string> ask(const std::string& request) const {
    boost::asio::ip::tcp::iostream stream("127.0.0.1", port_);
    stream << request << " HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n" << std::flush;
    const std::string text{std::istreambuf_iterator<char>(stream), {}};
    const std::size_t end = text.find("\r\n\r\n");
    return {text.substr(0, end), end == std::string::npos ? "" : text.substr(end + 4)};
  }
  std::string metrics() const {
    const auto [head, body] = ask("GET /metrics");
    EXPECT_THAT(head, StartsWith("HTTP/1.1 200 OK"));
    EXPECT_THAT(head, HasSubstr("Content-Type: text/plain; version=0.0.4; charset=utf-8"));
    return body;
  }

  BoardProcess& process() { return process_; }

 private:
  BoardProcess process_;
  std::string port_;
};

std::set<std::string> words_of(const std::string& name) {
  std::istringstream stream(name);
  std::set<std::string> words;
  for (std::string word; std::getline(stream, word, '_');) words.insert(word);
  return words;
}

// What is wrong with the name and type of a metric.
std::vector<std::string> faults_of(const std::string& name, const std::string& type) {
  std::vector<std::string> faults;
  const auto expect = [&](bool good, const std::string& rule) {
    if (!good) faults.push_back(name + ": " + rule);
  };
  expect(name.ends_with("_total") == (type == "counter"), "counters, and they alone, end with _total");
  for (const char* suffix : {"_count", "_sum", "_bucket"}) expect(!name.ends_with(suffix), "kept for histograms");
  for (const std::string& word : words_of(name)) {
    static const std::set<std::string> abbreviated{"s",  "ms", "us", "ns", "ps", "sec", "b", "kb",
                                                   "mb", "gb", "tb", "pb", "m",  "h",   "d"};
    static const std::set<std::string> scaled{"milliseconds", "microseconds", "nanoseconds", "picoseconds",
                                              "minutes",      "hours",        "days",        "kilobytes",
                                              "megabytes",    "gigabytes",    "bits"};
    static const std::set<std::string> types{"counter", "gauge", "histogram", "summary", "untyped"};
    expect(!abbreviated.contains(word), "abbreviated unit " + word);
    expect(!scaled.contains(word), "not a base unit: " + word);
    expect(!types.contains(word), "its type in its name");
  }
  return faults;
}

struct Sample {
  std::map<std::string, std::string> labels;
  double value = 0;
};
using Metrics = std::multimap<std::string, Sample>;

Metrics parse(const std::string& text, std::vector<std::string>& faults) {
  static const std::regex kHelp("# HELP ([a-z][a-z0-9_]*) (.+)"), kType("# TYPE ([a-z][a-z0-9_]*) (counter|gauge)"),
      kSample(R"re(([a-z][a-z0-9_]*)\{((?:[a-z_]+="(?:[^"\\\n]|\\["\\n])*",?)+)\} ([0-9]+(?:\.[0-9]+)?))re"),
      kLabel(R"re(([a-z_]+)="((?:[^"\\\n]|\\["\\n])*)")re");
  Metrics metrics;
  std::set<std::string> described, sample_lines;
  std::string helped, current;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    std::smatch match;
    if (std::regex_match(line, match, kHelp)) {
      helped = match[1];
      if (!described.insert(helped).second) faults.push_back("described twice: " + line);
    } else if (std::regex_match(line, match, kType)) {
      current = match[1];
      if (current != helped) faults.push_back("no help before " + line);
      for (const std::string& fault : faults_of(current, match[2])) faults.push_back(fault);
    } else if (std::regex_match(line, match, kSample)) {
      if (match[1] != current) faults.push_back("not below its type: " + line);
      if (!sample_lines.insert(line.substr(0, line.rfind(' '))).second) faults.push_back("twice: " + line);
      Sample sample{{}, std::stod(match[3])};
      const std::string labels = match[2];
      for (std::sregex_iterator label(labels.begin(), labels.end(), kLabel), end; label != end; ++label) {
        if (!sample.labels.emplace((*label)[1], (*label)[2]).second) faults.push_back("a label twice: " + line);
      }
      metrics.emplace(current, sample);
    } else {
      faults.push_back("neither comment nor sample: " + line);
    }
  }
  if (!text.empty() && !text.ends_with('\n')) faults.push_back("no newline at the end");
  return metrics;
}

Metrics parse(const std::string& text) {
  std::vector<std::string> faults;
  Metrics metrics = parse(text, faults);
  EXPECT_THAT(faults, IsEmpty());
  return metrics;
}

void work(Board& board) {
  const std::vector<std::byte> samples(32 * 32 * 32, std::byte{90});
  board.load_volume({.samples = samples, .type = SampleType::kUint8, .dims = {32, 32, 32}});
  board.set_transfer_function({.colours = {{0, {1, 1, 1}}}, .opacities = {{0, 0.1}}});
  View view;
  view.width = view.height = 16;
  view.eye = {100, 80, -60};
  view.look_at = {15.5, 15.5, 15.5};
  board.render(view);
}

TEST(Export, KeepsPrometheusRulesAtEveryLevel) {
  const OwnRegistry registry;
  const Exporter exporter;
  for (const std::string level : {"functional", "cycle"}) {
    for (const std::string memory : {"rdram", "ddr"}) {
      Board board = Board::open("emu:?fidelity=" + level + "&set=memory=" + memory);
      work(board);
      const Metrics metrics = parse(exporter.metrics());
      EXPECT_GT(metrics.size(), 40u) << level;
      const auto info = metrics.find("gicube_board_info");
      ASSERT_NE(info, metrics.end());
      EXPECT_EQ(info->second.labels.at("fidelity"), level);
      for (const auto& [name, sample] : metrics) EXPECT_TRUE(sample.labels.contains("pid")) << name;
    }
  }
}

TEST(Export, HasTheCountersThatTheApplicationReads) {
  const OwnRegistry registry;
  const Exporter exporter;
  Board board = Board::open("emu:?fidelity=cycle");
  work(board);
  const Counters counters = board.counters();
  const Metrics metrics = parse(exporter.metrics());
  const auto value = [&](const std::string& name) {
    EXPECT_EQ(metrics.count(name), 1u) << name;
    const auto found = metrics.find(name);
    return found == metrics.end() ? -1 : found->second.value;
  };
  EXPECT_EQ(value("gicube_bus_down_bytes_total"), static_cast<double>(counters.value("bus.down.bytes")));
  EXPECT_DOUBLE_EQ(value("gicube_bus_down_busy_seconds_total"),
                   static_cast<double>(counters.value("bus.down.busy_ps")) * 1e-12);
  EXPECT_EQ(value("gicube_pipeline_terminated_rays_total"), static_cast<double>(counters.value("pipeline.terminated")));
  EXPECT_EQ(value("gicube_dsp_busy_cycles_total"), static_cast<double>(counters.value("dsp.busy_cycles")));
  EXPECT_EQ(value("gicube_fidelity_answered_cycle_commands_total"),
            static_cast<double>(counters.value("fidelity_answered.cycle")));
  EXPECT_DOUBLE_EQ(value("gicube_board_simulated_seconds_total"), static_cast<double>(board.now()) * 1e-12);
  EXPECT_EQ(value("gicube_board_in_use"), 1);
  std::map<std::string, double> events;
  const auto [begin, end] = metrics.equal_range("gicube_audit_events_total");
  for (auto each = begin; each != end; ++each) events[each->second.labels.at("event")] = each->second.value;
  EXPECT_EQ(events.size(), 15u);
  EXPECT_EQ(events["opened"], 1);
  EXPECT_EQ(events["closed"], 0);
}

TEST(Export, ShowsHowMuchOfTheLimitsIsTaken) {
  const OwnRegistry registry;
  const Exporter exporter;
  const reference::TemporaryDirectory folder;
  const std::string path = folder.file("board");
  BoardProcess process({"--listen", "unix:" + path, "--max-memory", "16", "--quiet"});
  process.read_line();
  Board board = Board::open("unix:" + path);
  const auto value = [&exporter](const std::string& name) {
    const Metrics metrics = parse(exporter.metrics());
    EXPECT_EQ(metrics.count(name), 1u) << name;
    return metrics.count(name) == 1 ? metrics.find(name)->second.value : -1;
  };
  EXPECT_EQ(value("gicube_quota_limit_memory_bytes"), 16 << 20);
  const double before = value("gicube_quota_memory_bytes");
  work(board);
  EXPECT_GT(value("gicube_quota_memory_bytes"), before);
  EXPECT_LT(value("gicube_quota_memory_bytes"), 16 << 20);
  EXPECT_EQ(value("gicube_quota_limit_connections"), 32);
  EXPECT_EQ(value("gicube_quota_connections"), 0);
  EXPECT_GT(value("gicube_quota_limit_results_bytes"), value("gicube_quota_results_bytes"));
}

TEST(Export, LabelsProcessorsAndLeavesTheirSumToTheReader) {
  const OwnRegistry registry;
  const Exporter exporter;
  Board board = Board::open("emu:?fidelity=cycle");
  work(board);
  const Counters counters = board.counters();
  const Metrics metrics = parse(exporter.metrics());
  const auto sum_of = [&](const std::string& name, const std::string& label, const std::string& value) {
    double sum = 0;
    std::set<std::string> processors;
    const auto [begin, end] = metrics.equal_range(name);
    for (auto each = begin; each != end; ++each) {
      const std::map<std::string, std::string>& labels = each->second.labels;
      if (!label.empty() && labels.at(label) != value) continue;
      sum += each->second.value;
      EXPECT_TRUE(labels.contains("processor")) << name;
      if (labels.contains("processor")) processors.insert(labels.at("processor"));
    }
    EXPECT_EQ(processors, (std::set<std::string>{"0", "1", "2", "3"})) << name;
    return sum;
  };
  EXPECT_EQ(sum_of("gicube_processor_sorter_issued_rays_total", "", ""),
            static_cast<double>(counters.value("processor.sorter.issued")));
  EXPECT_EQ(sum_of("gicube_processor_cache_samples_with_misses_total", "misses", "1"),
            static_cast<double>(counters.value("processor.cache.samples_with_misses.1")));
}

TEST(Export, ABoardThatGoesAwayIsNoError) {
  const OwnRegistry registry;
  Exporter exporter;
  EXPECT_EQ(exporter.metrics(), "");
  {
    const Board board = Board::open("emu:");
    EXPECT_EQ(parse(exporter.metrics()).count("gicube_board_info"), 1u);
  }
  EXPECT_EQ(exporter.metrics(), "");
  BoardProcess killed({"--listen", "tcp:127.0.0.1:0"});
  killed.read_line();
  const Metrics before = parse(exporter.metrics());
  EXPECT_EQ(before.find("gicube_process_up")->second.value, 1);
  killed.send_signal(SIGSTOP);
  Metrics silent = parse(exporter.metrics());
  for (int i = 0; i < 100 && silent.size() != 1; ++i)
    silent = parse(exporter.metrics());  // a process stops when it is told, not at once
  ASSERT_EQ(silent.size(), 1u);
  EXPECT_EQ(silent.find("gicube_process_up")->second.value, 0);
  killed.send_signal(SIGKILL);
  killed.exit_code();
  EXPECT_EQ(exporter.metrics(), "");
  exporter.process().send_signal(SIGTERM);
  EXPECT_EQ(exporter.process().exit_code(), 0);
}

TEST(Export, AnswersOtherRequestsAsHttpAsks) {
  const OwnRegistry registry;
  const Exporter exporter;
  EXPECT_THAT(exporter.ask("GET /").first, StartsWith("HTTP/1.1 404"));
  EXPECT_THAT(exporter.ask("GET /").second, HasSubstr("/metrics"));
  EXPECT_THAT(exporter.ask("POST /metrics").first, StartsWith("HTTP/1.1 405"));
  EXPECT_THAT(exporter.ask("POST /metrics").first, HasSubstr("Allow: GET, HEAD"));
  const Board board = Board::open("emu:");
  const auto [head, body] = exporter.ask("HEAD /metrics");
  EXPECT_THAT(head, ContainsRegex("Content-Length: [1-9]"));
  EXPECT_EQ(body, "");
  exporter.ask("no request at all\r\n\r\n");
  EXPECT_THAT(exporter.metrics(), Not(IsEmpty()));
}

TEST(Export, ListensOnThisMachineOnly) {
  for (const char* refused : {"0.0.0.0:9500", "192.0.2.1:9500", "[::]:9500", "9500", "127.0.0.1", "127.0.0.1:", ":9500",
                              "127.0.0.1:65536", "example.org:9500", ""}) {
    const Finished run = run_program("gicube-smi", {"export", "--listen", refused});
    EXPECT_EQ(run.code, 2) << refused;
    EXPECT_THAT(run.err, HasSubstr("--listen")) << refused;
  }
  EXPECT_EQ(run_program("gicube-smi", {"export"}).code, 2);
}

}  // namespace
}  // namespace gicube::tools_test
