// A second opinion on what in a picture is the figure, from a small network for salient objects.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/values/image.h"

namespace keypose::capture {

/// The network's file in share/keypose. A stage that asks the network names it in its
/// `StageSpec::shared_files`, so that its version is part of the fingerprint.
inline constexpr char kSalienceFile[] = "isnet.onnx";
/// For warnings and reports where the network is missing and would have helped.
inline constexpr char kNoSalience[] = "the network is not installed: ./dev setup";

/// Values of a pixel are this far apart, so that the last bits of the network's sums, which differ
/// between processors, hardly ever reach them.
inline constexpr int kSalienceStep = 17;

struct SalienceOptions {
  int side_px = 512;  ///< side of the square that the network sees; 512 or 1024
};

/// How a picture is laid into the square that the network sees.
enum class SalienceFit {
  kStretched,  ///< to the square, as when the network learnt
  /// The shorter side is continued by the picture's mirror image on both sides: for close-ups,
  /// which stretched or beside a plain border often come back empty.
  kMirrored
};

/// Where the network is.
/// @return none: it is not installed
std::optional<std::filesystem::path> FindSalienceNetwork();

/// The network 'isnet'.
/// Source: Qin et al., "Highly accurate dichotomous image segmentation", ECCV 2022.
class SalienceNetwork {
 public:
  /// About a second, and 800 MB of memory (1 GB with 1024 pixels) until it is destroyed.
  /// @throws InputError  the file is not the network that this program knows
  /// @throws DiskError   cannot be read
  static std::unique_ptr<SalienceNetwork> Open(const std::filesystem::path& file,
                                               const SalienceOptions& options = {});
  ~SalienceNetwork();

  /// How likely each pixel belongs to the picture's one salient object, in steps of kSalienceStep
  /// from 0 to 255, at the picture's own size. Uses all cores; not for several threads at once.
  /// Same bits for any thread count.
  /// @throws InputError  no pixels, or not three channels
  Image8 Of(const Image8& rgb, SalienceFit fit = SalienceFit::kStretched) const;

 private:
  struct Impl;
  explicit SalienceNetwork(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace keypose::capture
