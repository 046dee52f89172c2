#include "capture/salience/salience_network.h"

#include <cmath>
#include <opencv2/dnn.hpp>
#include <opencv2/imgproc.hpp>

#include "capture/salience/single_precision.h"
#include "core/io/text/files.h"
#include "core/io/text/shared_files.h"
#include "core/numbers/parallel.h"
#include "core/numbers/sha256.h"
#include "core/values/errors.h"

namespace keypose::capture {
namespace {

// Of the network's bytes in @imgly/background-removal-data 1.4.5; cmake/SalienceNetwork.cmake has
// it too.
constexpr char kContent[] = "b6e8497ba978a6f5fbb647e419d2696cd80df5a23cb6a8ea532021911bd76acb";

/// OpenCV's threads as many as ours while it lives.
class OurThreads {
 public:
  OurThreads() : before_(cv::getNumThreads()) { cv::setNumThreads(ThreadCount()); }
  ~OurThreads() { cv::setNumThreads(before_); }
  OurThreads(const OurThreads&) = delete;
  OurThreads& operator=(const OurThreads&) = delete;

 private:
  int before_;
};

/// What stands beside the picture on each side where it is continued to a square [px].
struct Beside {
  int left = 0, right = 0, top = 0, bottom = 0;
};

Beside BesideOf(const Image8& rgb, SalienceFit fit) {
  if (fit == SalienceFit::kStretched) return {};
  const int across = std::max(rgb.height - rgb.width, 0),
            down = std::max(rgb.width - rgb.height, 0);
  return {across / 2, across - across / 2, down / 2, down - down / 2};
}

/// The picture at `side` x `side`, the mean of what each pixel covers, from -0.5 to 0.5.
cv::Mat InputOf(const Image8& rgb, const Beside& beside, int side) {
  cv::Mat picture(rgb.height, rgb.width, CV_8UC3, const_cast<std::uint8_t*>(rgb.data.data()));
  if (beside.right + beside.bottom > 0)
    cv::copyMakeBorder(picture, picture, beside.top, beside.bottom, beside.left, beside.right,
                       cv::BORDER_REFLECT);
  cv::Mat square;
  const bool smaller = picture.cols > side && picture.rows > side;
  cv::resize(picture, square, {side, side}, 0, 0, smaller ? cv::INTER_AREA : cv::INTER_LINEAR);
  return cv::dnn::blobFromImage(square, 1 / 256.0, {side, side}, cv::Scalar::all(128), false, false,
                                CV_32F);
}

std::uint8_t InSteps(float probability) {
  const float steps = 255.0F / kSalienceStep * std::min(std::max(probability, 0.0F), 1.0F);
  return static_cast<std::uint8_t>(kSalienceStep * static_cast<int>(std::lround(steps)));
}

}  // namespace

struct SalienceNetwork::Impl {
  mutable cv::dnn::Net net;
  int side = 0;
};

std::optional<std::filesystem::path> FindSalienceNetwork() { return FindSharedFile(kSalienceFile); }

SalienceNetwork::SalienceNetwork(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
SalienceNetwork::~SalienceNetwork() = default;

std::unique_ptr<SalienceNetwork> SalienceNetwork::Open(const std::filesystem::path& file,
                                                       const SalienceOptions& options) {
  if (options.side_px != 512 && options.side_px != 1024)
    throw UsageError("the network sees pictures of 512 or 1024 pixels, not of " +
                     std::to_string(options.side_px));
  auto impl = std::make_unique<Impl>();
  impl->side = options.side_px;
  std::string bytes = ReadFile(file);
  if (Sha256Of(bytes) != kContent)
    throw InputError(PrintableName(file) +
                     " is damaged, or another network than this program knows; install it again: "
                     "./dev setup, then ./dev build");
  bytes = SinglePrecisionNetwork(bytes, options.side_px);
  impl->net = cv::dnn::readNetFromONNX(bytes.data(), bytes.size());
  impl->net.setPreferableBackend(cv::dnn::DNN_BACKEND_OPENCV);
  impl->net.setPreferableTarget(cv::dnn::DNN_TARGET_CPU);
  return std::unique_ptr<SalienceNetwork>(new SalienceNetwork(std::move(impl)));
}

Image8 SalienceNetwork::Of(const Image8& rgb, SalienceFit fit) const {
  if (rgb.empty() || rgb.channels != 3)
    throw InputError("the network needs a picture with three channels");
  const OurThreads threads;
  const Beside beside = BesideOf(rgb, fit);
  impl_->net.setInput(InputOf(rgb, beside, impl_->side));
  const cv::Mat output = impl_->net.forward();
  const cv::Mat square(impl_->side, impl_->side, CV_32F, const_cast<float*>(output.ptr<float>()));
  cv::Mat full;
  cv::resize(square, full,
             {rgb.width + beside.left + beside.right, rgb.height + beside.top + beside.bottom}, 0,
             0, cv::INTER_LINEAR);
  Image8 salience(rgb.width, rgb.height, 1);
  for (int y = 0; y < rgb.height; ++y)
    for (int x = 0; x < rgb.width; ++x)
      *salience.at(x, y) = InSteps(full.at<float>(y + beside.top, x + beside.left));
  return salience;
}

}  // namespace keypose::capture
