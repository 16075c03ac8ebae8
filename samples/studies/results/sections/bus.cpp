#include <fmt/format.h>

#include <algorithm>

#include "studies/results/bench.h"

namespace gicube::samples::results {
namespace {

constexpr double kRate = 30;  // Hz

Run large_image(const Bench& bench) {
  Run run = bench.run(SceneName::kBuckyball);
  run.width = run.height = 2 * bench.design().image;
  run.picture = false;
  return run;
}

}  // namespace

void bus_section(Bench& bench) {
  Page& page = bench.page();
  page.heading("Host bus");
  const Run run = large_image(bench);
  Table table{"bus",
              {"bus", "image, ms", fmt::format("share of the bus at {:g} Hz", kRate), "host's rays", "MB down and up",
               "bus ms for them", "at most Hz", "there and back, ms", "Hz"}};
  double image_share = 0, pci = 0, agp = 0;
  for (const char* bus : {"pci33", "agp1x", "agp2x", "agp4x"}) {
    const Run on = bus == std::string("pci33") ? run : run.with("bus.model", bus);
    Run traced = on;
    traced.kind = Run::Kind::kHostRays;
    const Measurement &image = bench.get(on), &rays = bench.get(traced);
    const double image_ms = to_ms(image.counters.value("bus.image.time_ps")),
                 rays_ms = to_ms(rays.counters.value("bus.down.busy_ps") + rays.counters.value("bus.up.busy_ps"));
    const double share = image_ms * kRate * 1e-3;
    if (bus == std::string("pci33")) image_share = share, pci = rate_hz(rays);
    if (bus == std::string("agp2x")) agp = rate_hz(rays);
    table.rows.push_back(
        {bus, number(image_ms, 2), percent(share), std::to_string(rays.counters.value("dsp.host_rays")),
         number(static_cast<double>(rays.counters.value("bus.rays.bytes")) * 1e-6, 1), number(rays_ms, 1),
         number(ratio(1e3, rays_ms)), number(frame_ms(rays), 1), number(rate_hz(rays))});
  }
  page.text(
      fmt::format("The buckyball with {0}^2 pixels: the image's way to the host, and the same rays made by the host, "
                  "sent down, traced and sent back, 32 bytes each way.",
                  run.width));
  page.table(table);
  page.claim({21, fmt::format("512^2 images of 36 bit at {:g} Hz over PCI; host-made rays both ways (3.6)", kRate),
              "fits; floods the bus, AGP helps",
              fmt::format("{} of PCI's time; {:.1f} Hz on PCI, {:.1f} Hz on AGP 2x", percent(image_share), pci, agp),
              image_share > 1 || pci > kRate || agp < pci, "the bus is not what bounds these rays: see the table"});
}

}  // namespace gicube::samples::results
