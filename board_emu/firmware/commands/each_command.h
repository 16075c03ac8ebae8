// The DSP's commands: a class for each, with its own state. run() checks the payload, has its rays traced by the card's
// level, and reports the cost; it throws CommandFault.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "card.h"
#include "firmware/pixel_life.h"

namespace gicube::emu {

using Payload = std::span<const std::uint8_t>;

class CardCommand {
 public:
  explicit CardCommand(Card& card) : card_(card) {}

 protected:
  Card& card_;
};

class RenderImage : public CardCommand {
 public:
  using CardCommand::CardCommand;
  CommandResult run(Payload payload, Progress& work);
  // Reports the rays of this pixel for each following image.
  void set_explained(ExplainedPixel pixel) { explained_ = std::move(pixel); }

  std::uint64_t viewing_rays = 0;

 private:
  // Reports the rays of the pixel in explained_, for an image that is in the framebuffer.
  void explain(const wire::RenderCommand& command, const Frame& frame);
  void follow_pixel(const wire::RenderCommand& command, const Frame& frame, PixelLife& life);

  std::optional<ExplainedPixel> explained_;
};

class TraceRays : public CardCommand {
 public:
  using CardCommand::CardCommand;
  CommandResult run(Payload payload, Progress& work);

  std::uint64_t host_rays = 0;

 private:
  std::span<wire::Ray> take_in(const wire::TraceHeader& header, std::span<wire::Ray> rays);

  std::vector<wire::Ray> room_;  // rays of the current command
};

struct IlluminateVolume : CardCommand {
  using CardCommand::CardCommand;
  CommandResult run(Payload payload, Progress& work);
};

struct ResumeRays : CardCommand {
  using CardCommand::CardCommand;
  CommandResult run(Payload payload, Progress& work);
};

class VerifyBlocks : public CardCommand {
 public:
  using CardCommand::CardCommand;
  CommandResult run(Payload payload, Progress& work);

 private:
  Picoseconds reading_time(std::size_t first, std::size_t count) const;
};

struct TracePairs : CardCommand {
  using CardCommand::CardCommand;
  CommandResult run(Payload payload, Progress& work);

  std::uint64_t pair_rays = 0;
};

struct ContinueRays : CardCommand {
  using CardCommand::CardCommand;
  CommandResult run(Payload payload, Progress& work);
};

struct TakeRays : CardCommand {
  using CardCommand::CardCommand;
  CommandResult run(Payload payload);

  std::uint64_t forwarded_rays = 0;  // sent from the card
};

class GiveRays : public CardCommand {
 public:
  using CardCommand::CardCommand;
  CommandResult run(Payload payload);

  std::uint64_t arrived_rays = 0;  // sent to the card

 private:
  void begin_given(const wire::GiveRaysHeader& header);
};

struct LoadCoarse : CardCommand {
  using CardCommand::CardCommand;
  CommandResult run(Payload payload);
};

}  // namespace gicube::emu
