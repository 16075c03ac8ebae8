// A program on a board that does anything at random, for tests that stop it and let it go on elsewhere.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "gicube/board.h"
#include "gicube/wire/checksum.h"
#include "random_machine.h"
#include "test_board.h"
#include "voxels.h"

namespace gicube::system_test {

using emu::Dice;

inline constexpr int kBlock = 8;

template <typename T>
std::uint32_t sum_of(const std::vector<T>& values) {
  return wire::crc32c({reinterpret_cast<const std::uint8_t*>(values.data()), values.size() * sizeof(T)});
}

inline std::uint32_t sum_of(const std::vector<TracedRay>& rays) {
  std::vector<double> words;
  for (const TracedRay& ray : rays) {
    words.insert(words.end(), {static_cast<double>(ray.id), ray.position.x, ray.position.y, ray.position.z});
    words.insert(words.end(), {ray.direction.x, ray.direction.y, ray.direction.z, ray.opacity, ray.integral});
    words.insert(words.end(), ray.colour.begin(), ray.colour.end());
  }
  return sum_of(words);
}

inline std::uint32_t sum_of(const Image& image) {
  std::vector<std::uint16_t> words;
  for (const Pixel& pixel : image.pixels) {
    words.insert(words.end(), {pixel.red, pixel.green, pixel.blue, pixel.alpha});
  }
  return sum_of(words);
}

// A program that does anything at random; what it does depends on its seed and its step alone. Copied, it goes on on
// another board.
class RandomProgram {
 public:
  // `edge`: voxels of its volume's edges, at least 20.
  explicit RandomProgram(unsigned seed, int edge = 20) : seed_(seed), edge_(edge) {}

  const std::vector<std::string>& heard() const { return heard_; }

  void begin(Board& board) {
    std::vector<std::byte> samples;
    Dice dice(seed_);
    const Vec3 middle{dice.number(5, 14) * 1.0, 10, 9};
    for_each_voxel({edge_, edge_, edge_}, [&](int x, int y, int z) {
      const double in = 8 - length(Vec3{x * 1.0, y * 1.0, z * 1.0} - middle);
      samples.push_back(static_cast<std::byte>(std::clamp(100 + 20 * in, 0.0, 255.0)));
    });
    if (dice.chance(40)) {
      const std::vector<Vec3> codebook{{0, 0, 0}, {1, 0, 0}, {0, -1, 0}, {0, 0.6, 0.8}, {-0.6, 0, 0.8}};
      board.set_gradient_codebook(codebook);
    }
    board.load_volume({.samples = samples, .dims = {edge_, edge_, edge_}});
    board.set_transfer_function(step_function(0.3));
    hear(board, "loaded", 0);
  }

  void step(Board& board) {
    Dice dice(seed_ * 1000 + ++steps_);
    try {
      do_one(board, dice);
    } catch (const DeviceLost&) {
      throw;
    } catch (const Error& error) {
      hear(board, error.what(), 0);
    }
  }

  void end(Board& board) {
    while (!tickets_.empty()) receive(board, 0);
    board.set_time_limit(0);
    try {
      hear(board, "picture", sum_of(board.render(view_of(seed_))));
    } catch (const Rejected& error) {  // it has no light
      hear(board, error.what(), 0);
    } catch (const MemoryFault& error) {
      hear(board, error.what(), 0);
    }
    const Counters counters = board.counters();
    for (const Counter& each : counters.list()) {
      if (!each.name.starts_with("emulator.")) heard_.push_back(each.name + ' ' + std::to_string(each.value));
    }
  }

 private:
  void hear(const Board& board, const std::string& what, std::uint64_t sum) {
    heard_.push_back(fmt::format("{}: {:08x} at {}", what, sum, board.now()));
  }

  static View view_of(unsigned seed) {
    Dice dice(seed);
    View view;
    view.eye = {dice.number(-60, -30) * 1.0, dice.number(-20, 40) * 1.0, dice.number(-60, 60) * 1.0};
    view.look_at = {9.5, 9.5, 9.5};
    view.width = dice.number(4, 24);
    view.height = dice.number(4, 24);
    view.step = dice.one_of({0.5, 1.0});
    view.jitter = dice.chance(40);
    view.shade = dice.chance(60);
    view.leap = dice.chance(70);
    view.irradiance = dice.chance(25);
    view.scatter = dice.chance(15);
    if (dice.chance(30)) view.cut_planes.push_back({{1, 0, 0}, 4.5});
    return view;
  }

  void do_one(Board& board, Dice& dice) {
    switch (dice.number(0, 17)) {
      case 0: return hear(board, "picture", sum_of(board.render(view_of(seed_ + steps_))));
      case 1: return board.render_to_framebuffer(view_of(seed_ + steps_));
      case 2: return hear(board, "framebuffer", sum_of(board.read_framebuffer()));
      case 3: return board.set_transfer_function(step_function(dice.number(1, 9) / 10.0), dice.number(0, 1));
      case 4: {
        Shading shading;
        shading.phong.ambient = dice.number(0, 5) / 10.0;
        shading.light = {1, dice.number(-3, 3) * 1.0, 2};
        return board.set_shading(shading);
      }
      case 5: {
        const Material material{.scattering = 0.3,
                                .bsdf = dice.one_of({Bsdf::kIsotropic, Bsdf::kSpecular, Bsdf::kNone})};
        return board.set_material(material);
      }
      case 6: {
        const std::vector<Light> lights{PointLight{{-10, 5, dice.number(-9, 30) * 1.0}, 100}};
        const LightingReport report = board.illuminate(lights, {.rays_per_face_voxel = 1, .step = 1});
        return hear(board, "light", std::bit_cast<std::uint64_t>(report.deposited));
      }
      case 7: return hear(board, "irradiance", sum_of(board.read_irradiance({{3, 2, 1}, {9, 8, 7}})));
      case 8: {
        std::vector<float> values(27);
        for (float& value : values) value = static_cast<float>(dice.number(0, 255));
        return board.write_volume({{dice.number(0, 16), 3, dice.number(0, 16)}, {3, 3, 3}}, values);
      }
      case 9: return hear(board, "damaged", sum_of(board.verify_volume()));
      case 10: return board.host_compute(static_cast<Picoseconds>(dice.number(1, 2'000'000)));
      case 11: {
        if (tickets_.empty()) return;
        return receive(board, static_cast<std::size_t>(dice.number(0, static_cast<int>(tickets_.size()) - 1)));
      }
      case 12: {
        for (const RayBatch& batch : board.poll()) {
          hear(board, fmt::format("batch {}", batch.ticket.id), sum_of(batch.rays) + batch.completed);
          std::erase(tickets_, batch.ticket);
        }
        return;
      }
      case 13: return dice.chance(50) ? board.clear_irradiance(0.01) : board.clear_sums(0.01);
      case 14: {
        std::vector<std::uint8_t> flags = board.empty_flags();
        for (std::uint8_t& flag : flags) flag = dice.chance(10) ? 1 : flag;
        return board.set_empty_flags(flags);
      }
      case 15:
        return board.set_time_limit(dice.chance(50) ? 0 : static_cast<Picoseconds>(dice.number(1, 2'000'000'000)));
      default: return submit(board, dice);
    }
  }

  void submit(Board& board, Dice& dice) {
    const auto type = static_cast<RayType>(dice.number(0, 6));
    std::vector<HostRay> rays;
    const auto place = [&dice] {
      return Vec3{dice.number(0, 19) * 1.0, dice.number(0, 19) * 1.0, dice.number(0, 19) * 1.0};
    };
    for (int left = dice.chance(10) ? 5000 : dice.number(1, 150); left > 0; --left) {
      HostRay ray = ray_between(static_cast<std::uint32_t>(left), place(), place());
      if (type == RayType::kDeposit || type == RayType::kBackproject) ray.energy = 0.1;
      rays.push_back(ray);
    }
    const Sampling sampling = sampling_of(view_of(seed_ + steps_));
    const Ticket ticket = board.submit(rays, {.type = type, .opacity = 0.7, .step = 1, .sampling = sampling});
    tickets_.push_back(ticket);
    hear(board, fmt::format("ticket {}", ticket.id), 0);
    if (dice.chance(15)) hear(board, "cancelled", board.cancel(ticket) ? 1 : 0);
  }

  void receive(Board& board, std::size_t which) {
    const Ticket ticket = tickets_[which];
    try {
      const RayBatch batch = board.receive(ticket);
      hear(board, fmt::format("batch {}", ticket.id), sum_of(batch.rays) + (batch.cancelled ? 1 : 0));
      if (batch.lighting) heard_.push_back(fmt::format("deposited {}", batch.lighting->deposited));
    } catch (const DeviceLost&) {
      throw;
    } catch (const Error& error) {  // the batch is gone, or a poll that failed has taken it
      hear(board, error.what(), 0);
    }
    std::erase(tickets_, ticket);
  }

  unsigned seed_;
  int edge_;
  unsigned steps_ = 0;
  std::vector<Ticket> tickets_;
  std::vector<std::string> heard_;
};

}  // namespace gicube::system_test
