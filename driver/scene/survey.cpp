#include "gicube/scene/survey.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <unordered_map>
#include <vector>

#include "scene/common/checks.h"
#include "scene/formats/plane_file.h"

namespace gicube::scene {
namespace {

constexpr std::size_t kSamples = std::size_t{1} << 18;  // chosen: sorted in 20 ms, and percentiles within 0.2%

// Values in rising order, and pairs of neighbours along x.
struct Sampled {
  std::vector<float> values;
  std::vector<std::pair<float, float>> pairs;
  ValueRange whole{INFINITY, -INFINITY};
};

// Counts values that are whole numbers of 16 bits, and sorts others.
void sort(std::vector<float>& values) {
  constexpr float kLeast = -32768, kMost = 65535;
  if (!std::ranges::all_of(values, [](float v) { return v >= kLeast && v <= kMost && v == std::floor(v); })) {
    std::ranges::sort(values);
    return;
  }
  std::vector<std::uint32_t> counts(static_cast<std::size_t>(kMost - kLeast) + 1);
  for (const float value : values) ++counts[static_cast<std::size_t>(value - kLeast)];
  auto out = values.begin();
  for (std::size_t i = 0; i < counts.size(); ++i) out = std::fill_n(out, counts[i], kLeast + static_cast<float>(i));
}

Sampled sampled(const Volume& volume) {
  const std::size_t width = static_cast<std::size_t>(volume.dims[0]);
  std::size_t stride = std::max<std::size_t>(1, voxels_of(volume.dims) / kSamples);
  while (std::gcd(stride, width) != 1) ++stride;  // else whole columns are left out
  Sampled out;
  out.values.reserve(voxels_of(volume.dims) / stride + 1);
  out.pairs.reserve(voxels_of(volume.dims) / stride + 1);
  std::size_t next = 0;  // index in this plane
  for_each_plane(volume, [&](int, std::span<const std::byte> samples) {
    with_sample(volume.type, [&](auto sample) {
      using Sample = decltype(sample);
      const std::size_t count = samples.size() / sizeof sample;
      if constexpr (sizeof(Sample) > 1) {
        for (std::size_t i = 0; i < count; ++i) {
          const double value = static_cast<double>(sample_at<Sample>(samples, i));
          if (std::isfinite(value)) out.whole = {std::min(out.whole.low, value), std::max(out.whole.high, value)};
        }
      }
      for (; next < count; next += stride) {
        const float value = static_cast<float>(sample_at<Sample>(samples, next));
        if (!std::isfinite(value)) continue;
        out.values.push_back(value);
        if ((next + 1) % width != 0)
          out.pairs.emplace_back(value, static_cast<float>(sample_at<Sample>(samples, next + 1)));
      }
      next -= count;
    });
  });
  sort(out.values);
  return out;
}

double percentile(std::span<const float> sorted, double percent) {
  return sorted[static_cast<std::size_t>(std::lround(percent / 100 * static_cast<double>(sorted.size() - 1)))];
}

std::span<const float> above(std::span<const float> sorted, double value) {
  const auto first = std::upper_bound(sorted.begin(), sorted.end(), static_cast<float>(value));
  return sorted.subspan(static_cast<std::size_t>(first - sorted.begin()));
}
double share_between(std::span<const float> sorted, double low, double high) {
  return sorted.empty() ? 0
                        : static_cast<double>(above(sorted, low).size() - above(sorted, high).size()) /
                              static_cast<double>(sorted.size());
}

// Detects integers in plateaus: nearly every value has neighbours of the same value, unlike values at the edges between
// two materials of a scan. Returns the number of values; 0: they are not labels.
std::size_t labels_in(const Sampled& all) {
  const float least = all.values.front(), most = all.values.back();
  const double span = double{most} - least;
  std::size_t small_steps = 0, steps = 0;
  bool only_two = true;
  for (const auto& [value, next] : all.pairs) {
    if (value != std::floor(value)) return 0;
    only_two = only_two && (value == least || value == most);
    if (next == value) continue;
    ++steps;
    if (std::abs(double{next} - value) <= 0.02 * span) ++small_steps;
  }
  if (!only_two && small_steps * 2 > steps) return 0;
  struct Count {
    std::size_t pairs = 0, equal = 0;
  };
  std::unordered_map<float, Count> counts;
  Count* last = nullptr;  // of the last pair's value, which is often the next one's too
  float counted = NAN;
  for (const auto& [value, next] : all.pairs) {
    if (value != counted) last = &counts[counted = value];
    ++last->pairs;
    if (next == value) ++last->equal;
  }
  if (counts.size() < 2 || counts.size() > 4096) return 0;
  std::size_t flat = 0, seen = 0;
  for (const auto& [value, count] : counts) {
    if (count.pairs < 4 && counts.size() > 2) continue;
    ++seen;
    if (count.equal * 3 > count.pairs) ++flat;
  }
  return counts.size() == 2 || (flat * 10 >= seen * 8 && seen >= 2) ? counts.size() : 0;
}

// Smoothed counts of values over `low`..`high`.
struct Histogram {
  double low, step;
  std::vector<double> counts;

  Histogram(std::span<const float> sorted, double from, double to) : low(from) {
    const bool whole = std::ranges::all_of(sorted, [](float value) { return value == std::floor(value); });
    // Each bin has the same number of integers, otherwise some would be higher.
    step = whole ? std::max(1.0, std::ceil((to - from) / 128)) : std::max((to - from) / 128, 1e-30);
    const double bins = std::floor((to - from) / step) + 1;
    std::vector<double> raw(static_cast<std::size_t>(bins));
    for (const float value : sorted) {
      const double bin = (double{value} - low) / step;
      if (bin >= 0 && bin < bins + 1e-6) raw[std::min(static_cast<std::size_t>(bin), raw.size() - 1)] += 1;
    }
    counts = raw;
    for (std::size_t i = 1; i + 1 < raw.size(); ++i) counts[i] = (raw[i - 1] + 2 * raw[i] + raw[i + 1]) / 4;
  }
  double value_at(std::size_t bin) const { return low + (static_cast<double>(bin) + 0.5) * step; }
  std::size_t tallest(std::size_t first, std::size_t last) const {
    const auto at = [this](std::size_t i) { return counts.begin() + static_cast<std::ptrdiff_t>(i); };
    return static_cast<std::size_t>(std::max_element(at(first), at(std::min(last, counts.size()))) - counts.begin());
  }
  // The first bin from `bin` on, upwards or downwards, with less than this share of its count.
  std::size_t falls(std::size_t bin, double share, int way) const {
    std::size_t i = bin;
    while (counts[i] > share * counts[bin] && i + 1 < counts.size() && (way > 0 || i > 0))
      i += static_cast<std::size_t>(way);
    return i;
  }
};

// The peak of the most common material above the background; none if counts only decrease.
struct Peak {
  double value = 0, width = 0, end = 0;  // width: at half of the count; end: where the count is a twentieth
  double below = 0, above = 0;           // relative counts at 0.7 and at 1.3 of its value above the background
};
std::optional<Peak> peak_after(const Histogram& histogram, std::size_t bin, double background) {
  const std::vector<double>& counts = histogram.counts;
  std::size_t valley = bin;
  for (std::size_t i = bin; i < counts.size() && counts[i] <= 1.5 * counts[valley]; ++i) {
    if (counts[i] < counts[valley]) valley = i;
  }
  if (valley + 2 >= counts.size()) return std::nullopt;
  const std::size_t top = histogram.tallest(valley, counts.size());
  double all = 0, more = 0;  // counts above the background, and those of them that make the rise
  for (std::size_t i = bin; i < counts.size(); ++i) {
    all += counts[i];
    if (i > valley) more += std::max(0.0, counts[i] - counts[valley]);
  }
  if (counts[top] <= 1.5 * counts[valley] || more < 0.005 * all) return std::nullopt;  // rare values' counts vary
  const double width = static_cast<double>(histogram.falls(top, 0.5, 1) - histogram.falls(top, 0.5, -1)) - 1;
  const double value = histogram.value_at(top);
  const auto share_at = [&](double up) {
    const auto at = static_cast<std::size_t>((background + up * (value - background) - histogram.low) / histogram.step);
    return at < counts.size() ? counts[at] / counts[top] : 0;
  };
  return Peak{value, std::max(width, 1.0) * histogram.step, histogram.value_at(histogram.falls(top, 0.05, 1)),
              share_at(0.7), share_at(1.3)};
}

// Whether these values, without padding, are Hounsfield units as written by scanners.
bool in_hounsfield(std::span<const float> sorted) {
  const double low = percentile(sorted, 0.05), high = percentile(sorted, 99.9);
  if (low < -1300 || high < 100 || high > 5000) return false;
  const double air = share_between(sorted, -1100, -850), body = share_between(sorted, -150, 150);
  if (low < -500) return air > 0.01 && body > 0.02 && air + body + share_between(sorted, -850, -150) > 0.6;
  // Without air: tissue alone, with fat below water and bone above.
  const double usual = percentile(sorted, 50);
  return low < -30 && low > -300 && usual > -150 && usual < 200 && high > 300 && body > 0.5;
}

std::string shown_value(double value) { return fmt::format("{:.4g}", value); }

// Cuts a single extreme value, which would leave few densities for all others.
double without_extreme(double whole, double usual, double span) {
  return std::abs(whole - usual) > 2 * span ? usual + std::copysign(0.5 * span, whole - usual) : whole;
}

// Whether there are hardly any edges.
bool is_smooth(const std::vector<std::pair<float, float>>& pairs, double span) {
  const auto edges = std::ranges::count_if(
      pairs, [span](const auto& pair) { return std::abs(double{pair.first} - pair.second) > 0.06 * span; });
  return static_cast<double>(edges) < 0.005 * static_cast<double>(pairs.size());
}

void tell_kind(std::span<const float> sorted, const std::vector<std::pair<float, float>>& pairs, Survey& survey) {
  const double low = percentile(sorted, 0.05), high = percentile(sorted, 99.95);
  if (in_hounsfield(sorted)) {
    survey.kind = DataKind::kCt;
    survey.why = "the values are Hounsfield units, as air near -1000 and soft tissue near 0 say";
    if (low > -500) survey.why = "the values are Hounsfield units, as fat, soft tissue and bone round 0 say";
    survey.robust = {std::max(low, -1000.0), high};
    return;
  }
  const Histogram histogram(sorted, low, high);
  const std::size_t bins = histogram.counts.size();
  const std::size_t air = histogram.tallest(0, std::max<std::size_t>(1, bins * 35 / 100));
  const std::size_t all = histogram.tallest(0, bins);
  const double middle = (histogram.value_at(all) - low) / (high - low);
  if (low < 0 && high > 0 && middle > 0.25 && middle < 0.75 && std::abs(histogram.value_at(all)) < 0.1 * (high - low)) {
    survey.kind = DataKind::kSigned;
    const double most = std::max(-low, high);
    survey.robust = {-most, most};
    survey.why = "the values lie on both sides of 0";
    return;
  }
  const bool has_background = share_between(sorted, low - 1, histogram.value_at(histogram.falls(air, 0.05, 1))) > 0.1 &&
                              histogram.falls(air, 0.05, 1) < bins / 2;
  const std::size_t edge = has_background ? histogram.falls(air, 0.05, 1) : 0;
  const double background = has_background ? histogram.value_at(air) - 0.5 * histogram.step : low;
  const std::span<const float> body = above(sorted, has_background ? histogram.value_at(edge) : low);
  survey.robust = {background, body.empty() ? high : percentile(body, 99.9)};
  if (!(survey.robust.low < survey.robust.high)) survey.robust = {low, std::max(high, std::nextafter(low, INFINITY))};
  survey.why = "the values are none of the kinds that have a preset of their own";
  if (body.empty() || !has_background) return;
  survey.usual = percentile(body, 50);
  const double share = static_cast<double>(body.size()) / static_cast<double>(sorted.size());
  const std::optional<Peak> peak = peak_after(histogram, edge, background);
  if (share < 0.02) return;
  if (!peak) {
    survey.why = "above the background, higher values only become rarer, as in a cloud";
    return;
  }
  const double up = peak->value - background, top = survey.robust.high - background;
  const double tail = share_between(body, background + 1.25 * up, INFINITY);
  const bool narrow = peak->width < 0.28 * up && peak->below < 0.3 && peak->above < 0.1;
  // Where air is near 0 and tissue near 1024, as CT is stored without a sign, bone may be less dense.
  const bool is_offset = std::abs(background) < 80 && up > 970 && up < 1110;
  const bool has_bone = top > (is_offset ? 1.4 : 2.1) * up && top < 4.6 * up && tail > 0.003 && tail < 0.5;
  if (narrow && has_bone && up > 0.2 * (peak->end - background)) {
    survey.kind = DataKind::kCt;
    survey.ct = {background, background + up / 1.04};
    survey.why = fmt::format("the values are those of a CT: air at {}, soft tissue at {}, and bone above",
                             shown_value(background), shown_value(peak->value));
  } else if (top > 8 * up) {
    survey.kind = DataKind::kMicroCt;
    survey.usual = peak->end;
    survey.why = fmt::format("a long tail lies above the commonest material, at {}, as bone's does in a micro-CT",
                             shown_value(peak->value));
  } else if (narrow) {
    survey.kind = DataKind::kPart;
    survey.usual = peak->value;
    survey.why = fmt::format("most of what is above the background is one material, at {}", shown_value(peak->value));
    if (share_between(body, background + 1.25 * up, INFINITY) > 0.002) {
      survey.why += ", with denser ones in it";
    } else if (share_between(body, background + 0.1 * up, background + 0.9 * up) > 0.6) {
      survey.kind = DataKind::kOther;
      survey.why = "most of what is above the background has no edge, as in a cloud";
    } else {
      survey.kind = DataKind::kSolid;
    }
  } else if (is_smooth(pairs, high - low)) {
    survey.why = "the values change slowly from voxel to voxel, as those of a computed field";
  } else if (survey.usual - background < 0.4 * up) {
    survey.kind = DataKind::kSolid;
    survey.usual = peak->value;
    survey.why = fmt::format("one material, at {}, lies above the noise", shown_value(peak->value));
  } else {
    survey.kind = top > 2.8 * (survey.usual - background) ? DataKind::kMriT2 : DataKind::kMri;
    survey.why = survey.kind == DataKind::kMri
                     ? "the materials overlap in their values, as tissues do in an MRI"
                     : "the materials overlap, and few values are far above, as fluid in a T2-weighted MRI";
  }
}

template <typename Map>
TransferFunctionFile mapped(const TransferFunctionFile& file, const Map& map) {
  TransferFunctionFile out{file.function, TransferScale::kAbsolute};
  for (ColourPoint& point : out.function.colours) point.value = map(point.value);
  for (OpacityPoint& point : out.function.opacities) point.value = map(point.value);
  return out;
}

// Maps the range `from` of the function's values to the range `to` of the volume's.
TransferFunctionFile between(const TransferFunctionFile& file, const ValueRange& from, const ValueRange& to) {
  const double slope = (to.high - to.low) / (from.high - from.low);
  // Six digits, so that a function is the same after writing it to a file.
  return mapped(file, [&](double value) {
    return *parse_number<double>(fmt::format("{:.6g}", to.low + (value - from.low) * slope));
  });
}

}  // namespace

Survey survey_of(const Volume& volume) {
  Survey survey;
  const Sampled all = sampled(volume);
  if (all.values.empty()) throw InputError("samples", "at least one finite value", "none");
  std::span<const float> sorted = all.values;
  const ValueRange seen = bytes_per_sample(volume.type) > 1 ? all.whole : ValueRange{sorted.front(), sorted.back()};
  survey.whole = volume.type == SampleType::kUint8    ? ValueRange{0, 255}
                 : volume.type == SampleType::kUint12 ? ValueRange{0, 4095}
                                                      : seen;
  survey.range = survey.robust = survey.whole;
  if (!(seen.low < seen.high)) {
    survey.kind = DataKind::kConstant;
    survey.why = "all its values are " + shown_value(seen.low);
    return survey;
  }
  if (!(sorted.front() < sorted.back())) return survey;  // single voxels differ
  if (const std::size_t count = labels_in(all); count > 0) {
    survey.kind = count == 2 ? DataKind::kMask : DataKind::kLabels;
    survey.range = survey.robust = {std::min(seen.low, 0.0), seen.high};
    survey.why = count == 2 ? fmt::format("it has two values, {} and {}: a mask", shown_value(sorted.front()),
                                          shown_value(sorted.back()))
                            : fmt::format("its values are {} whole numbers in plateaus: labels", count);
    return survey;
  }
  const std::span<const float> rest = above(sorted, sorted.front());
  const double body_span = percentile(sorted, 99.9) - double{rest.front()};
  if (rest.size() + sorted.size() / 200 < sorted.size() && rest.size() * 20 > sorted.size() &&
      double{rest.front()} - sorted.front() > 0.15 * body_span) {
    survey.padding = sorted.front();
    sorted = rest;
  }
  const double low = percentile(sorted, 0.05), high = percentile(sorted, 99.95);
  if (volume.type != SampleType::kUint8 && volume.type != SampleType::kUint12) {
    const double least = survey.padding ? double{sorted.front()} : survey.whole.low;
    survey.range = {without_extreme(least, low, high - low), without_extreme(survey.whole.high, high, high - low)};
  } else if (sorted.back() < survey.whole.high / 10) {
    survey.range = {0, std::max(double{sorted.back()}, 1.0)};
  }
  tell_kind(sorted, all.pairs, survey);
  // The background of a masked scan, which has one value, resembles padding.
  if (survey.kind == DataKind::kOther && survey.padding && double{rest.front()} - *survey.padding < 2 * body_span) {
    const Survey before = survey;
    survey.padding.reset();
    tell_kind(all.values, all.pairs, survey);
    if (survey.kind == DataKind::kOther) survey = before;
  }
  if (survey.kind == DataKind::kCt) {
    const auto value = [&](double hu) { return survey.ct.low + (hu + 1000) / 1000 * (survey.ct.high - survey.ct.low); };
    survey.has_bone = share_between(above(sorted, value(-300)), value(250), INFINITY) > 0.003;
  }
  if (survey.padding) survey.why += fmt::format("; {} is padding", shown_value(*survey.padding));
  return survey;
}

TransferFunctionFile in_values_of(const Survey& survey, const ValueRange& range, const TransferFunctionFile& file) {
  switch (file.scale) {
    case TransferScale::kAbsolute: break;
    case TransferScale::kNormalised: return between(file, {0, 1}, range);
    case TransferScale::kHounsfield: return between(file, {-1000, 0}, survey.ct);
    case TransferScale::kRobust: return between(file, {0, 1}, survey.robust);
  }
  return file;
}

AutomaticLook automatic_look(const Survey& survey, const std::optional<ValueRange>& given) {
  const auto look = [&](const char* name, const ValueRange& from, const ValueRange& to) {
    const TransferFunctionFile preset = find_preset(name);
    const bool labels = survey.kind == DataKind::kLabels || survey.kind == DataKind::kMask;
    const bool own = given && preset.scale != TransferScale::kHounsfield;
    return AutomaticLook{
        name, own ? between(preset, {0, 1}, *given) : between(preset, from, to),
        fmt::format("transfer function: {}, since {}", labels ? "colours of labels" : name, survey.why)};
  };
  const ValueRange& robust = survey.robust;
  switch (survey.kind) {
    case DataKind::kMask:
    case DataKind::kLabels: return look("surface", {0, 1}, {0, robust.high > 0 ? robust.high : 1});
    case DataKind::kCt: return look(survey.has_bone ? "ct-bone" : "ct-skin", {-1000, 0}, survey.ct);
    // These are the positions of the end of soft tissue, and of the usual tissue of a brain, in the presets.
    case DataKind::kMicroCt: return look("micro-ct-bone", {0.12, 1}, {survey.usual, robust.high});
    case DataKind::kPart: return look("ct-engine", {0, 1}, robust);
    case DataKind::kSolid: return look("surface", {0, 1}, {robust.low, survey.usual});
    case DataKind::kMri: return look("mri-brain", {0, 0.54}, {robust.low, survey.usual});
    case DataKind::kMriT2: return look("mri-t2", {0, 0.27}, {robust.low, survey.usual});
    case DataKind::kSigned: return look("diverging", {0, 1}, robust);
    case DataKind::kConstant:
    case DataKind::kOther: break;
  }
  return look("ramp", {0, 1}, robust.low < robust.high ? robust : ValueRange{robust.low, robust.low + 1});
}

}  // namespace gicube::scene
