// Events of chosen rays against the counters of the parts, and against the picture.
#include "observe/events.h"

#include <nlohmann/json.hpp>

#include "full_disk.h"
#include "observe/observation.h"
#include "observe/observers.h"
#include "observed_scene.h"
#include "read_trace.h"
#include "temporary_directory.h"
#include "test.h"

namespace gicube::emu {
namespace {

constexpr int kImage = 24;

std::vector<gicube_event> events_of(const std::string& items, Machine& machine, const Scene& scene) {
  std::vector<gicube_event> out;
  Events events(parse_selection(items), [&out](const gicube_event& event) { out.push_back(event); });
  machine.set_observer(&events);
  cycle_picture(scene, corner_view(kObservedSize, kImage), machine);
  machine.set_observer(nullptr);
  return out;
}

std::map<std::string, std::uint64_t> counted(const std::vector<gicube_event>& events) {
  std::map<std::string, std::uint64_t> out;
  for (const gicube_event& event : events) ++out[std::string(kRayStepNames.at(event.kind))];
  return out;
}

std::uint64_t counter(const Machine& machine, const std::string& name) {
  std::vector<wire::Counter> list;
  count(machine, list);
  for (const wire::Counter& each : list) {
    if (each.name == name) return each.value;
  }
  throw std::runtime_error("no counter " + name);
}

TEST(Events, OfAllRaysAreTheCountersOfTheParts) {
  for (const auto& more : std::vector<std::vector<std::string>>{
           {}, {"asic.queue_rays=2"}, {"sorter.queues=single", "asic.queue_rays=4"}, {"cache.ports=2"}}) {
    Machine machine(observed_config(more), {3, 3, 3});
    const ObservedScene scene;
    const std::vector<gicube_event> events = events_of("rays=0:1000000", machine, scene);
    auto steps = counted(events);
    EXPECT_EQ(steps["sampled"], counter(machine, "processor.samples"));
    EXPECT_EQ(steps["queued"], counter(machine, "processor.sorter.written"));
    EXPECT_EQ(steps["issued"], counter(machine, "processor.sorter.issued"));
    EXPECT_EQ(steps["overflowed"], counter(machine, "processor.sorter.overflows"));
    EXPECT_EQ(steps["kept"], counter(machine, "dsp.overflows"));
    EXPECT_EQ(steps["linked"], counter(machine, "link.rays_sent"));
    EXPECT_EQ(steps["arrived"], steps["linked"]);
    EXPECT_EQ(steps["sent"], counter(machine, "dsp.rays_sent"));
    EXPECT_EQ(steps["taken"], counter(machine, "dsp.rays_taken"));
    EXPECT_EQ(steps["made"], steps["taken"]);
    std::uint64_t packets = 0, waited = 0, missed = 0;
    for (const gicube_event& event : events) {
      if (event.kind == GICUBE_EVENT_SAMPLED) packets += event.count, missed += event.count > 0 ? 1 : 0;
      if (event.kind == GICUBE_EVENT_FILLED) waited += event.count;
    }
    EXPECT_EQ(packets, counter(machine, "processor.cache.packets"));
    EXPECT_EQ(steps["filled"], missed);
    std::uint64_t stood = 0;
    for (const char* cause : {"cache_fill", "cache_miss", "memory_bank", "refresh"}) {
      stood += counter(machine, std::string("processor.cycles.") + cause);
    }
    // The cause of a cycle in which nothing came to the line's end goes back to when nothing entered, which may be a
    // miss too.
    EXPECT_LE(waited, stood);
    EXPECT_GT(waited, stood / 2);
  }
}

TEST(Events, TellOneRaysLifeInItsOrder) {
  Machine machine(observed_config(), {3, 3, 3});
  const ObservedScene scene;
  const std::vector<gicube_event> events = events_of("pixel=12:12", machine, scene);
  ASSERT_GE(events.size(), 6u);
  EXPECT_EQ(events.front().kind, GICUBE_EVENT_MADE);
  EXPECT_EQ(events[1].kind, GICUBE_EVENT_SENT);
  EXPECT_EQ(events[2].kind, GICUBE_EVENT_QUEUED);
  EXPECT_EQ(events[3].kind, GICUBE_EVENT_ISSUED);
  EXPECT_EQ(events.back().kind, GICUBE_EVENT_TAKEN);
  Cycle last = 0;
  std::int16_t at = -1;
  for (const gicube_event& event : events) {
    EXPECT_GE(event.cycle, last);
    EXPECT_EQ(event.ray, events.front().ray);
    EXPECT_EQ(event.u >> 4, 12);
    EXPECT_EQ(event.v >> 4, 12);
    if (event.kind == GICUBE_EVENT_ARRIVED || at < 0) at = event.processor;
    if (event.kind == GICUBE_EVENT_SAMPLED) {
      EXPECT_EQ(event.processor, at);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        EXPECT_EQ(static_cast<std::uint32_t>(event.sample_position[axis] >> wire::kPositionFractionBits) / 8,
                  event.block[axis]);
      }
    }
    last = event.cycle;
  }
}

// What was accumulated is what the image has; and a sample's colour and opacity, composited once more, is what was
// accumulated.
TEST(Events, EndWithTheWordsOfThePicture) {
  for (const auto& more : std::vector<std::vector<std::string>>{{}, {"asic.datapath=wide"}}) {
    const reference::TemporaryDirectory folder;
    ObservationOptions options;
    options.event_file = folder.file("e");
    options.events = parse_selection("rays=0:100000");
    std::vector<wire::Pixel> image;
    {
      Observation observation(options);
      BareBoard board(observed_config(more), &observation);
      board.load_volume(kObservedSize, observed_voxel);
      board.write_segmentation([](unsigned, unsigned density) { return observed_material(density); });
      image = board.render(corner_view(kObservedSize, kImage));
    }
    std::istringstream lines(read_text(folder.file("e")));
    std::map<std::uint64_t, double> clear;
    int taken = 0, visible = 0;
    for (std::string line; std::getline(lines, line);) {
      const nlohmann::json event = nlohmann::json::parse(line);
      const std::uint64_t ray = event["ray"];
      if (event["event"] == "sampled") {
        const double opacity = event["sample"]["opacity"];
        clear.try_emplace(ray, 1.0);
        clear[ray] *= 1 - opacity;
        visible += opacity > 0 ? 1 : 0;
        EXPECT_NEAR(1 - clear[ray], event["opacity"].get<double>() / wire::kOpacityOne, 1e-5);
      }
      if (event["event"] != "taken") continue;
      ++taken;
      const auto x = static_cast<std::size_t>(event["pixel"][0].get<double>()),
                 y = static_cast<std::size_t>(event["pixel"][1].get<double>());
      const wire::Pixel& pixel = image.at(y * kImage + x);
      const std::array<int, 3> bytes{pixel.red, pixel.green, pixel.blue};  // one = 255, of a word with one = 4095
      for (std::size_t c = 0; c < 3; ++c) EXPECT_EQ((event["colour"][c].get<int>() * 255 + 2047) / 4095, bytes[c]);
    }
    EXPECT_GT(taken, kImage * kImage / 4);
    EXPECT_GT(visible, 100);
  }
}

TEST(Events, ChangeNoCycleNoCounterAndNoBit) {
  std::mt19937 random(7);
  for (int round = 0; round < 12; ++round) {
    const std::uint64_t begin = random() % 3000, length = 1 + random() % 500;
    const v1::BoardConfig config =
        observed_config(round % 2 == 0 ? std::vector<std::string>{} : std::vector<std::string>{"asic.queue_rays=3"});
    Machine plain(config, {3, 3, 3}), observed(config, {3, 3, 3});
    const ObservedScene scene;
    const Picture expected = cycle_picture(scene, corner_view(kObservedSize, kImage), plain);
    Events events(parse_selection("rays=5:9,counters=" + std::to_string(1 + random() % 40) +
                                  ",cycles=" + std::to_string(begin) + ':' + std::to_string(begin + length)),
                  [](const gicube_event&) {});
    Observers all;
    all.add(events);
    observed.set_observer(&all);
    const Picture seen = cycle_picture(scene, corner_view(kObservedSize, kImage), observed);
    EXPECT_EQ(seen.pixels, expected.pixels);
    std::vector<wire::Counter> mine, its;
    count(plain, mine);
    count(observed, its);
    EXPECT_EQ(mine, its) << "cycles from " << begin;
  }
}

TEST(Events, KeepToPartsCyclesAndRays) {
  Machine machine(observed_config(), {3, 3, 3});
  const ObservedScene scene;
  const std::vector<gicube_event> events =
      events_of("rays=250:300,parts=sorter+links,cycles=2000:9000", machine, scene);
  ASSERT_FALSE(events.empty());
  for (const gicube_event& event : events) {
    EXPECT_TRUE(event.ray >= 250 && event.ray < 300 && event.cycle >= 2000 && event.cycle < 9000);
    EXPECT_THAT(kRayStepNames.at(event.kind), testing::AnyOf("queued", "overflowed", "issued", "linked", "arrived"));
  }
}

TEST(Events, OfCountersComeInTheirCyclesForEachProcessor) {
  Machine machine(observed_config(), {3, 3, 3});
  const ObservedScene scene;
  const std::vector<gicube_event> events = events_of("counters=100,cycles=2450:3000", machine, scene);
  ASSERT_EQ(events.size(), 5u * 3);
  std::uint64_t samples = 0;
  for (std::size_t i = 0; i < events.size(); ++i) {
    EXPECT_EQ(events[i].kind, GICUBE_EVENT_COUNTERS);
    EXPECT_EQ(events[i].cycle, 2500 + i / 3 * 100);
    EXPECT_EQ(events[i].processor, static_cast<int>(i % 3));
    if (i % 3 != 0) continue;
    EXPECT_GE(events[i].values[0], samples);
    samples = events[i].values[0];
  }
  EXPECT_GT(samples, 0u);
}

TEST(Selection, RefusesWhatIsNoSelectionWithWhatWasExpected) {
  const std::map<std::string, std::string> faulty{
      {"", "expected pixel, life, rays or counters among them"},
      {"pixel=3", "pixel: expected X:Y of 0 to 4095, got \"3\""},
      {"pixel=4096:0", "pixel: expected X:Y"},
      {"rays=7:7", "rays: expected BEGIN:END with BEGIN < END, got \"7:7\""},
      {"rays=0:5,cycles=x:y", "cycles: expected BEGIN:END"},
      {"rays=0:5,parts=dsp+bus", "parts: expected some of dsp, sorter, pipeline, links with + between, got \"bus\""},
      {"rays=0:5,parts=", "parts: expected some of"},
      {"counters=0", "counters: expected a number of cycles from 1 on, got \"0\""},
      {"colour=red", "item: expected one of pixel, life, rays, cycles, parts, counters"}};
  for (const auto& [text, expected] : faulty) {
    EXPECT_THROWS(std::invalid_argument, expected, parse_selection(text));
  }
}

TEST(MachineTrace, OfAWindowHasItsCyclesAndNoOthers) {
  const reference::TemporaryDirectory folder;
  ObservationOptions options;
  options.trace_file = folder.file("t");
  options.trace_window = {700, 1500};
  std::int64_t begin_ns = 0;
  {
    Observation observation(options);
    BareBoard board(observed_config(), &observation);
    board.load_volume(kObservedSize, observed_voxel);
    board.write_segmentation([](unsigned, unsigned density) { return observed_material(density); });
    board.render(corner_view(kObservedSize, kImage));
    board.render(corner_view(kObservedSize, kImage));
  }
  const ReadTrace trace = read_trace(read_text(folder.file("t")));
  ASSERT_EQ(trace.slices.at("DSP/commands").size(), 2u);
  begin_ns = trace.slices.at("DSP/commands").front().begin_ns;
  const auto& slices = trace.slices.at("processor 0/pipeline");
  EXPECT_EQ(slices.front().begin_ns, begin_ns + 700 * 10);
  EXPECT_EQ(slices.back().end_ns, begin_ns + 1500 * 10);
}

}  // namespace
}  // namespace gicube::emu
