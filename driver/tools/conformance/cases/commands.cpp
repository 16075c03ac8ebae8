// Commands, their completions and their errors.
#include <cmath>
#include <limits>

#include "gicube/board.h"
#include "tools/conformance/host.h"
#include "tools/conformance/scene.h"

namespace gicube::conformance {
namespace {

wire::RenderCommand small_picture(const Volume& volume) { return along(2, true, volume, 4, 3, 1); }

constexpr Case kCases[] = {
    {0, "command.unknown", "P410",
     [](Host& host) {
       for (const std::uint32_t opcode : {0u, 99u, ~0u}) {
         const RawFrame done = host.completion(host.command(words({opcode, 0, 0, 0})));
         check(done.header.error == ErrorCode::kBadValue || done.header.error == ErrorCode::kUnsupported,
               "opcode {}: expected error 6 or 7, got {}", opcode, fmt::underlying(done.header.error));
         check(done.text().find("opcode") != std::string::npos, "expected a text that names the opcode");
         check_same("STATUS", host.read_register(reg::kStatus), wire::kStatusBadCommand);
         host.write_register(reg::kStatusClear, ~0u);
       }
     }},
    {0, "command.no_volume", "P413",
     [](Host& host) {
       wire::RenderCommand command;
       command.width = command.height = 2;
       command.forward = {0, 0, 1};
       host.refused(command, "VOLUME_X");
       host.write_register(reg::kVolumeX, 4);
       host.write_register(reg::kVolumeY, 4);
       host.refused(command, "VOLUME_X");
     }},
    {0, "command.fields", "P411",
     [](Host& host) {
       const Volume volume(host, {4, 4, 4});
       const auto refused = [&](const char* name, auto field, auto value) {
         wire::RenderCommand command = small_picture(volume);
         command.*field = value;
         host.refused(command, name);
       };
       using Render = wire::RenderCommand;
       refused("width", &Render::width, std::uint16_t{0});
       refused("width", &Render::width, std::uint16_t{4096});
       refused("height", &Render::height, std::uint16_t{0});
       refused("height", &Render::height, std::uint16_t{4096});
       refused("projection", &Render::projection, static_cast<wire::Projection>(2));
       refused("samples_per_axis", &Render::samples_per_axis, std::uint8_t{0});
       refused("samples_per_axis", &Render::samples_per_axis, std::uint8_t{3});
       refused("samples_per_axis", &Render::samples_per_axis, std::uint8_t{8});
       refused("filter", &Render::filter, static_cast<wire::Filter>(2));
       refused("origin", &Render::origin, Vector{std::nan(""), 0, 0});
       refused("dv", &Render::dv, Vector{0, 0, std::numeric_limits<double>::infinity()});
       Bytes cut = wire::encoded(small_picture(volume));
       cut.pop_back();
       host.refused(cut, "payload");
       render(host, small_picture(volume));
     }},
    {0, "command.completion", "P401",
     [](Host& host) {
       const Volume volume(host, {4, 4, 4});
       const RawFrame done = host.completion(host.command(wire::encoded(small_picture(volume))));
       check_same("the completion's error", done.header.error, ErrorCode::kNone);
       check_same("bytes of a rendering's completion", done.payload.size(), 0);
       check(host.completions.empty(), "expected one completion, got {} more", host.completions.size());
     }},
    {0, "command.order", "P404",
     [](Host& host) {
       const Volume volume(host, {4, 4, 4});
       std::vector<std::uint32_t> tickets;
       for (int i = 0; i < 3; ++i) tickets.push_back(host.command(wire::encoded(small_picture(volume))));
       host.request(FrameType::kWait, words({tickets.back()}));
       check_same("completions before the answer", host.completions.size(), 3);
       for (std::size_t i = 0; i < 3; ++i) {
         check_same("their order by tickets", host.completions[i].header.id, tickets[i]);
         check(host.completions[i].header.time_ps <= host.now, "expected a completion before the answer's {} ps",
               host.now);
       }
     }},
    {0, "command.poll", "P403",
     [](Host& host) {
       const Volume volume(host, {4, 4, 4});
       host.command(wire::encoded(small_picture(volume)));
       host.now += 1'000'000'000'000;  // a second
       const std::uint64_t asked = host.now;
       host.request(FrameType::kPoll, {});
       check_same("completions with kPoll", host.completions.size(), 1);
       check_same("the time of the answer to kPoll", host.now, asked);
     }},
    {0, "command.wait_unknown", "P405",
     [](Host& host) {
       const Volume volume(host, {4, 4, 4});
       const std::uint32_t ticket = host.command(wire::encoded(small_picture(volume)));
       host.completion(ticket);
       for (const std::uint32_t wrong : {ticket, 99u}) {
         host.refused_request(FrameType::kWait, words({wrong}), ErrorCode::kBadValue);
       }
     }},
    {0, "command.ticket", "P406",
     [](Host& host) {
       const Volume volume(host, {4, 4, 4});
       const Bytes command = wire::encoded(small_picture(volume));
       host.wire().send(FrameType::kCommand, 500, wire::kPosted, command);
       host.wire().send(FrameType::kCommand, 500, wire::kPosted, command);
       host.ends(ErrorCode::kProtocol, 500);
     }},
    {0, "command.far_time", "P911",
     [](Host& host) {
       FrameHeader header{FrameType::kPoll, 0, 1};
       header.time_ps = (std::uint64_t{1} << 62) + 1;
       host.wire().send(header);
       check_same("the error", next_answer(host.wire()).header.error, ErrorCode::kBadValue);
     }},
    {0, "driver.ball", "P1604",
     [](Place& place) {
       OpenOptions options;
       options.watchdog = place.silence();
       options.wait_for_board = place.silence();
       auto board = Board::open(place.uri(), options);
       constexpr int kEdge = 24;
       std::vector<std::byte> voxels;
       for (int i = 0; i < kEdge * kEdge * kEdge; ++i) {
         const Vec3 p{i % kEdge - 11.5, i / kEdge % kEdge - 11.5, i / kEdge / kEdge - 11.5};
         voxels.push_back(static_cast<std::byte>(std::clamp(128 + 16 * (8 - length(p)), 0.0, 255.0)));
       }
       board.load_volume({.samples = voxels, .type = SampleType::kUint8, .dims = {kEdge, kEdge, kEdge}});
       board.set_transfer_function({.colours = {{0, {1.0, 0.6, 0.3}}}, .opacities = {{96, 0.0}, {160, 0.4}}});
       View view;
       view.width = view.height = 32;
       view.eye = {60, 50, -40};
       view.look_at = {11.5, 11.5, 11.5};
       const Image image = board.render(view);
       const Pixel centre = image.at(16, 16), corner = image.at(0, 0);
       check(centre.alpha > 3500 && centre.red > centre.blue, "expected an orange ball in the centre, got alpha {}",
             centre.alpha);
       check(corner.alpha == 0, "expected nothing in the corner, got alpha {}", corner.alpha);
     }},
};

}  // namespace

std::span<const Case> command_cases() { return kCases; }

}  // namespace gicube::conformance
