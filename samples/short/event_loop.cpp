// An event loop: a program waits for its user and for its board at the same time, with poll(2).
//
// Another thread simulates the user, who clicks into the picture. For each click the loop sends a ray and continues.
// When the board has traced it, the batch's descriptor becomes readable (Board::descriptor()), and the loop receives
// the hit. So clicks never wait for the board, and hits never wait for the user.
//
//   c++ -std=c++20 -O2 event_loop.cpp $(pkg-config --cflags --libs gicube) -o event_loop
//   ./event_loop
//
// Prints the first hits. Returns 1 unless each click has one answer within half a voxel of the ball's surface.
#include <gicube/board.h>
#include <poll.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <map>
#include <thread>

#include "voxels.h"

using gicube::Vec3;

constexpr int kEdge = 64;
constexpr double kMiddle = 31.5, kRadius = 24;
constexpr std::uint32_t kClicks = 40;

struct Click {
  std::uint32_t number;
  double x, y;  // voxels
};

int main() {
  auto board = gicube::Board::open("emu:");
  const std::vector<std::byte> voxels = make_ball(kEdge, kRadius);
  board.load_volume({.samples = voxels, .dims = {kEdge, kEdge, kEdge}});
  board.set_transfer_function({.colours = {{0, {1, 1, 1}}}, .opacities = {{128, 0}, {128, 1}}});  // a step

  int user[2];  // the loop reads from the first
  if (::pipe(user) != 0) return 1;
  std::thread clicks([&] {
    for (std::uint32_t i = 0; i < kClicks; ++i) {
      const Click click{i, kMiddle + 14 * std::cos(i), kMiddle + 14 * std::sin(i)};
      if (::write(user[1], &click, sizeof click) != sizeof click) return;
    }
    ::close(user[1]);
  });

  std::map<int, gicube::Ticket> under_way;  // by descriptor
  std::vector<int> answers(kClicks);
  double most = 0;  // distance from the surface
  for (bool more = true; more || !under_way.empty();) {
    std::vector<pollfd> events;
    if (more) events.push_back({user[0], POLLIN, 0});
    for (const auto& [descriptor, ticket] : under_way) events.push_back({descriptor, POLLIN, 0});
    if (::poll(events.data(), events.size(), -1) < 0) return 1;
    for (const pollfd& event : events) {
      if (event.revents == 0) continue;
      if (event.fd == user[0]) {
        Click click;
        more = ::read(user[0], &click, sizeof click) == sizeof click;
        if (!more) continue;
        const gicube::HostRay ray{click.number, {click.x, click.y, 0}, {0, 0, 1}};
        const gicube::Ticket ticket =
            board.submit(std::span(&ray, 1), {.type = gicube::RayType::kFirstHit, .opacity = 0.5, .step = 0.25});
        under_way[board.descriptor(ticket)] = ticket;
      } else {
        const gicube::TracedRay hit = board.receive(under_way.at(event.fd)).rays.at(0);  // does not wait
        under_way.erase(event.fd);
        ::close(event.fd);
        ++answers.at(hit.id);
        most = std::max(most, std::abs(length(hit.position - Vec3{kMiddle, kMiddle, kMiddle}) - kRadius));
        if (hit.id < 3)
          std::printf("click %u: (%.2f, %.2f, %.2f)\n", hit.id, hit.position.x, hit.position.y, hit.position.z);
      }
    }
  }
  clicks.join();
  ::close(user[0]);
  const auto once = std::ranges::count(answers, 1);
  std::printf("%td of %u clicks were answered once, at most %.2f voxels off the surface\n", once, kClicks, most);
  return once != kClicks || most > 0.5;
}
