#include "composite/scene/plate_colors.h"

#include <OpenColorIO/OpenColorIO.h>
#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <optional>

#include "core/io/text/files.h"
#include "core/numbers/parallel.h"
#include "core/pictures/srgb.h"
#include "core/values/errors.h"
#include "core/values/file_names.h"

namespace keypose::composite {
namespace {

namespace OCIO = OCIO_NAMESPACE;
namespace fs = std::filesystem;
using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr const char* kAces = "ACES2065-1";

/// Names of OpenColorIO's built-in ways to ACES2065-1.
struct CameraLog {
  const char *name, *style;
};
constexpr CameraLog kCameraLogs[] = {
    {"ACEScct", "ACEScct_to_ACES2065-1"},
    {"ACEScc", "ACEScc_to_ACES2065-1"},
    {"arri-logc3", "ARRI_ALEXA-LOGC-EI800-AWG_to_ACES2065-1"},
    {"sony-slog3", "SONY_SLOG3-SGAMUT3_to_ACES2065-1"},
    {"sony-slog3-cine", "SONY_SLOG3-SGAMUT3.CINE_to_ACES2065-1"},
    {"sony-slog3-venice", "SONY_SLOG3-SGAMUT3-VENICE_to_ACES2065-1"},
    {"sony-slog3-cine-venice", "SONY_SLOG3-SGAMUT3.CINE-VENICE_to_ACES2065-1"},
    {"panasonic-vlog", "PANASONIC_VLOG-VGAMUT_to_ACES2065-1"},
    {"red-log3g10", "RED_LOG3G10-RWG_to_ACES2065-1"},
    {"red-logfilm", "RED_REDLOGFILM-RWG_to_ACES2065-1"},
    {"canon-clog2", "CANON_CLOG2-CGAMUT_to_ACES2065-1"},
    {"canon-clog3", "CANON_CLOG3-CGAMUT_to_ACES2065-1"},
    {"adx10", "ADX10_to_ACES2065-1"},
    {"adx16", "ADX16_to_ACES2065-1"}};
constexpr const char* kOwnNames[] = {"linear", "ACES2065-1", "ACEScg", "cineon", "rec709", "srgb"};

/// "S-Log3" and "slog3" are one name.
std::string Plain(const std::string& name) {
  std::string plain;
  for (const char c : name)
    if (std::isalnum(static_cast<unsigned char>(c)))
      plain += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return plain;
}

/// Scene light of a code value of Cineon, as films are scanned: 685 is white, 95 black.
/// Source: Kodak, Conversion of 10-bit log film data to 8-bit linear or video data, 1995.
float LightOfCineon(float value) {
  const auto density = [](double code) { return std::pow(10.0, (code - 685) * 0.002 / 0.6); };
  static const double kBlack = density(95);
  return static_cast<float>((density(1023.0 * value) - kBlack) / (1 - kBlack));
}

/// Source: ITU-R BT.709, the camera's curve turned round.
float LightOfVideo(float value) {
  return static_cast<float>(value < 0.081 ? value / 4.5
                                          : std::pow((value + 0.099) / 1.099, 1 / 0.45));
}

float LightOfSrgb(float value) { return static_cast<float>(LinearFromSrgb(value)); }

std::function<void(float*, long, int)> EachValue(float (*light)(float)) {
  return [light](float* pixels, long count, int channels) {
    for (long i = 0; i < count; ++i)
      for (int c = 0; c < 3; ++c) pixels[i * channels + c] = light(pixels[i * channels + c]);
  };
}

OCIO::ConstCPUProcessorRcPtr ExactOf(const OCIO::ConstProcessorRcPtr& processor) {
  return processor->getOptimizedCPUProcessor(OCIO::BIT_DEPTH_F32, OCIO::BIT_DEPTH_F32,
                                             OCIO::OPTIMIZATION_LOSSLESS);
}

std::function<void(float*, long, int)> CurveOf(const OCIO::ConstCPUProcessorRcPtr& exact) {
  return [exact](float* pixels, long count, int channels) {
    OCIO::PackedImageDesc image(pixels, count, 1, channels);
    exact->apply(image);
  };
}

/// The matrix that a processor is, if it is one over the range of scene light.
std::optional<Matrix3d> MatrixOf(const OCIO::ConstCPUProcessorRcPtr& exact) {
  const auto apply = [&](const Vector3d& light) -> Vector3d {
    Eigen::Vector3f value = light.cast<float>();
    exact->applyRGB(value.data());
    return value.cast<double>();
  };
  Matrix3d matrix;
  for (int c = 0; c < 3; ++c) matrix.col(c) = apply(Vector3d::Unit(c));
  for (const Vector3d& light :
       {Vector3d(0, 0, 0), Vector3d(0.18, 0.18, 0.18), Vector3d(0.01, 0.5, 0.2),
        Vector3d(12, 0.3, 4), Vector3d(-0.05, 0.2, 0.9)})
    if (!((apply(light) - matrix * light).norm() <= 1e-4 * (light.norm() + 0.01))) return {};
  return matrix;
}

OCIO::ConstConfigRcPtr OwnConfig() {
  const OCIO::ConfigRcPtr config = OCIO::Config::CreateRaw()->createEditableCopy();
  const auto add = [&](const char* name, const Matrix3d* to_aces) {
    const OCIO::ColorSpaceRcPtr space = OCIO::ColorSpace::Create();
    space->setName(name);
    if (to_aces) {
      double values[16] = {};
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) values[4 * i + j] = (*to_aces)(i, j);
      values[15] = 1;
      const OCIO::MatrixTransformRcPtr matrix = OCIO::MatrixTransform::Create();
      matrix->setMatrix(values);
      space->setTransform(matrix, OCIO::COLORSPACE_DIR_TO_REFERENCE);
    }
    config->addColorSpace(space);
  };
  const Matrix3d aces_from_rec709 = LightFrom(kAcesAp0, kRec709);
  add(kAces, nullptr);
  add("rec709", &aces_from_rec709);
  return config;
}

/// A person's configuration, and a space in it whose colours are known.
class PersonsConfig {
 public:
  explicit PersonsConfig(const fs::path& path) : path_(PrintableName(path)) {
    try {
      config_ = OCIO::Config::CreateFromFile(path.string().c_str());
      config_->validate();
    } catch (const OCIO::Exception& fault) {
      throw InputError(
          fmt::format("{} is no OpenColorIO configuration that OpenColorIO {} reads: "
                      "{}",
                      path_, OCIO::GetVersion(), WithoutOddBytes(fault.what())));
    }
    FindKnown();
  }

  std::string SpaceFor(const std::string& name, const fs::path& plate) const {
    const std::string asked =
        name.empty() ? std::string(config_->getColorSpaceFromFilepath(plate.string().c_str()))
                     : name;
    const OCIO::ConstColorSpaceRcPtr space = config_->getColorSpace(asked.c_str());
    if (!space) throw UsageError(NoSuchSpace(asked));
    if (space->isData())
      throw UsageError(fmt::format(
          "the colour space '{}' of {} is for data, not for colours; {}", space->getName(), path_,
          name.empty() ? "say what the plate has: --plate_colorspace" : "name the plate's"));
    return space->getName();
  }

  std::string SceneLinear() const {
    const OCIO::ConstColorSpaceRcPtr space = config_->getColorSpace(OCIO::ROLE_SCENE_LINEAR);
    if (!space)
      throw InputError(path_ +
                       " has no role scene_linear, which says in what the light of a log "
                       "plate is counted; add it to the configuration");
    return space->getName();
  }

  OCIO::ConstCPUProcessorRcPtr Way(const std::string& from, const std::string& to) const {
    return Guarded([&] { return config_->getProcessor(from.c_str(), to.c_str()); });
  }
  /// To Rec.709 in linear light, if the space is linear.
  std::optional<Matrix3d> Rec709From(const std::string& space) const {
    return MatrixOf(Guarded([&] {
      return OCIO::Config::GetProcessorFromConfigs(config_, space.c_str(), known_.c_str(),
                                                   OwnConfig(), "rec709", known_as_);
    }));
  }

 private:
  template <class Get>
  OCIO::ConstCPUProcessorRcPtr Guarded(const Get& get) const {
    try {
      return ExactOf(get());
    } catch (const OCIO::Exception& fault) {
      throw InputError(fmt::format("{}: {}", path_, WithoutOddBytes(fault.what())));
    }
  }

  void FindKnown() {
    const auto find = [&](std::initializer_list<const char*> names, const char* as) {
      for (const char* name : names)
        if (known_.empty() && config_->getColorSpace(name)) {
          known_ = name;
          known_as_ = as;
        }
    };
    find({OCIO::ROLE_INTERCHANGE_SCENE, "ACES2065-1", "ACES - ACES2065-1", "aces2065_1", "lin_ap0"},
         kAces);
    find({"Linear Rec.709 (sRGB)", "lin_rec709", "lin_srgb", "Utility - Linear - Rec.709",
          "Utility - Linear - sRGB", "Linear - Rec.709", "Linear - sRGB"},
         "rec709");
    if (known_.empty())
      throw InputError(fmt::format(
          "{} does not say how its colours relate to those of others: it has neither the role "
          "aces_interchange nor a space that is named ACES2065-1; add the role, with the space of "
          "ACES2065-1 (AP0), to the configuration",
          path_));
  }

  std::string NoSuchSpace(const std::string& asked) const {
    std::vector<std::string> names;
    for (int i = 0; i < config_->getNumColorSpaces(); ++i)
      names.emplace_back(config_->getColorSpaceNameByIndex(i));
    return fmt::format("{} has no colour space '{}'{}", path_, asked,
                       names.empty() ? "" : "; did you mean '" + NearestWord(asked, names) + "'?");
  }

  std::string path_;
  OCIO::ConstConfigRcPtr config_;
  std::string known_;
  const char* known_as_ = nullptr;
};

/// OpenColorIO's way of this name to ACES2065-1; none if it has none.
std::optional<std::string> BuiltinStyle(const std::string& name) {
  const auto registry = OCIO::BuiltinTransformRegistry::Get();
  for (std::size_t i = 0; i < registry->getNumBuiltins(); ++i) {
    const std::string style = registry->getBuiltinStyle(i);
    const std::size_t end = style.rfind(std::string("_to_") + kAces);
    if (end == std::string::npos || style.find(' ') != std::string::npos) continue;
    if (Plain(style) == Plain(name) || Plain(style.substr(0, end)) == Plain(name)) return style;
  }
  return {};
}

/// @throws UsageError  the end of the names of several
std::optional<std::string> CameraStyle(const std::string& name) {
  const std::string plain = Plain(name);
  for (const CameraLog& log : kCameraLogs)
    if (Plain(log.name) == plain) return log.style;
  std::vector<CameraLog> ends;  // without the maker's name, such as "S-Log3"
  for (const CameraLog& log : kCameraLogs)
    if (plain.size() >= 4 && Plain(log.name).ends_with(plain)) ends.push_back(log);
  if (ends.empty()) return BuiltinStyle(name);
  if (ends.size() == 1) return ends[0].style;
  std::vector<std::string> names;
  for (const CameraLog& log : ends) names.emplace_back(log.name);
  throw UsageError(fmt::format("plate_colorspace '{}' may be {}; write one of them in full", name,
                               fmt::join(names, " or ")));
}

OCIO::ConstProcessorRcPtr BuiltinWay(const std::string& style) {
  const OCIO::BuiltinTransformRcPtr transform = OCIO::BuiltinTransform::Create();
  transform->setStyle(style.c_str());
  return OCIO::Config::CreateRaw()->getProcessor(transform);
}

}  // namespace

std::string KnownColorspaces() {
  std::string names;
  for (const char* name : kOwnNames) names += (names.empty() ? "" : ", ") + std::string(name);
  for (const CameraLog& log : kCameraLogs) names += std::string(", ") + log.name;
  return names;
}

PlateColors::PlateColors(const StatedColors& stated, const fs::path& path,
                         const LightFile& header) {
  OCIO::SetLoggingLevel(OCIO::LOGGING_LEVEL_NONE);
  if (!stated.config.empty())
    TakeConfig(stated, path);
  else if (!stated.colorspace.empty())
    TakeNamed(stated.colorspace, header);
  else
    header.exr ? TakeExr(header) : TakeDpx(path, header);
}

void PlateColors::TakePrimaries(const Primaries& primaries) {
  primaries_ = primaries;
  light_from_rec709_ = LightFrom(primaries, kRec709);
}

void PlateColors::TakeConfig(const StatedColors& stated, const fs::path& path) {
  const PersonsConfig config(stated.config);
  const std::string space = config.SpaceFor(stated.colorspace, path);
  std::optional<Matrix3d> rec709_from = config.Rec709From(space);
  meaning_ = fmt::format("'{}' of {}", space, PrintableName(stated.config.filename()));
  if (!rec709_from) {
    const std::string linear = config.SceneLinear();
    rec709_from = config.Rec709From(linear);
    if (!rec709_from)
      throw InputError(fmt::format("{}: its role scene_linear is '{}', which is not linear",
                                   PrintableName(stated.config), linear));
    curve_ = CurveOf(config.Way(space, linear));
    meaning_ += fmt::format(", made linear as '{}'", linear);
  }
  light_from_rec709_ = rec709_from->inverse();
  primaries_ = PrimariesOf(light_from_rec709_);
}

void PlateColors::TakeNamed(const std::string& name, const LightFile& header) {
  meaning_ = name;
  const std::string plain = Plain(name);
  if (plain == "linear") return TakeExr(header);
  if (plain == "aces20651") return TakePrimaries(kAcesAp0);
  if (plain == "acescg") return TakePrimaries(kAcesAp1);
  if (plain == "cineon") return void(curve_ = EachValue(LightOfCineon));
  if (plain == "rec709") return void(curve_ = EachValue(LightOfVideo));
  if (plain == "srgb") return void(curve_ = EachValue(LightOfSrgb));
  const std::optional<std::string> style = CameraStyle(name);
  if (!style)
    throw UsageError(fmt::format(
        "plate_colorspace '{}' is not known without an OpenColorIO configuration (--ocio_config); "
        "known are {}, and the built-in ways to ACES2065-1 of OpenColorIO {}",
        name, KnownColorspaces(), OCIO::GetVersion()));
  TakePrimaries(kAcesAp0);
  curve_ = CurveOf(ExactOf(BuiltinWay(*style)));
  meaning_ = fmt::format("{} ({})", name, *style);
}

void PlateColors::TakeExr(const LightFile& header) {
  const std::optional<Primaries> primaries =
      header.chromaticities ? PrimariesOf(*header.chromaticities) : std::nullopt;
  meaning_ = "linear light of Rec.709's primaries, as it states no others";
  if (!primaries) return;
  TakePrimaries(*primaries);
  const char* whose = SamePrimaries(*primaries, kAcesAp0)   ? "ACES2065-1"
                      : SamePrimaries(*primaries, kAcesAp1) ? "ACEScg"
                      : SamePrimaries(*primaries, kRec709)  ? "linear Rec.709"
                                                            : "linear light of its own primaries";
  meaning_ = fmt::format("{}, by its chromaticities", whose);
}

void PlateColors::TakeDpx(const fs::path& path, const LightFile& header) {
  const std::string plain = Plain(header.transfer);
  meaning_ = fmt::format("'{}', as its header states", header.transfer);
  if (plain == "linear") {
    if (header.writer.starts_with("Lavc"))
      doubt_ =
          "ffmpeg states so of every DPX; if the plate is log or video, say so by "
          "--plate_colorspace";
    return;
  }
  if (plain == "printingdensity" || plain == "logarithmic" || plain == "kodaklog")
    return void(curve_ = EachValue(LightOfCineon));
  if (plain.empty() || plain == "undefined" || plain == "userdefined") {
    curve_ = EachValue(LightOfCineon);
    meaning_ = "Cineon's log";
    doubt_ =
        "its header does not state what its values are; if they are no Cineon log, say what by "
        "--plate_colorspace";
    return;
  }
  if (plain == "adx") return TakeNamed(header.bits > 10 ? "adx16" : "adx10", header);
  if (plain.find("709") != std::string::npos || plain.find("601") != std::string::npos ||
      plain.find("274") != std::string::npos || plain.find("video") != std::string::npos)
    return void(curve_ = EachValue(LightOfVideo));
  throw InputError(fmt::format(
      "{}: its header states the transfer '{}', which is no light of a plate; if that is wrong, "
      "say what its values are by --plate_colorspace",
      PrintableName(path), header.transfer));
}

namespace {

/// RGB, in place.
void Multiply(const Matrix3d& by, ImageF* light) {
  if (by.isIdentity()) return;
  const Eigen::Matrix3f matrix = by.cast<float>();
  ParallelBlocks(static_cast<std::int64_t>(light->data.size()) / 3, 1 << 16,
                 [&](std::int64_t begin, std::int64_t end) {
                   for (std::int64_t i = begin; i < end; ++i) {
                     Eigen::Map<Eigen::Vector3f> pixel(light->data.data() + 3 * i);
                     pixel = (matrix * pixel).eval();
                   }
                 });
}

}  // namespace

void PlateColors::TakeFromRec709(ImageF* light) const { Multiply(light_from_rec709_, light); }

void PlateColors::GiveRec709(ImageF* light) const { Multiply(light_from_rec709_.inverse(), light); }

void PlateColors::Decode(ImageF* values) const {
  if (!curve_) return;
  const int channels = values->channels;
  ParallelBlocks(static_cast<std::int64_t>(values->data.size()) / channels, 1 << 16,
                 [&](std::int64_t begin, std::int64_t end) {
                   curve_(values->data.data() + channels * begin, end - begin, channels);
                 });
}

}  // namespace keypose::composite
