#include "capture/salience/single_precision.h"

#include <gtest/gtest.h>

#include <opencv2/dnn.hpp>
#include <string>
#include <vector>

#include "capture/salience/testing/written_fields.h"
#include "core/values/errors.h"

namespace keypose::capture::single_precision_test {

std::string WholeNumbers(const std::vector<std::int64_t>& numbers) {
  return {reinterpret_cast<const char*>(numbers.data()), numbers.size() * 8};
}

std::string Node(const std::string& operation, const std::vector<std::string>& inputs,
                 const std::string& output, const std::string& attributes = {}) {
  std::string node;
  for (const std::string& input : inputs) node += Bytes(1, input);
  return Bytes(1, node + Bytes(2, output) + Bytes(3, output) + Bytes(4, operation) + attributes);
}

std::string NumberAttribute(const std::string& name, std::uint64_t value) {
  return Bytes(5, Bytes(1, name) + Integer(3, value) + Integer(20, 2));
}

std::string ListAttribute(const std::string& name, const std::vector<std::uint64_t>& values) {
  std::string list;
  for (const std::uint64_t value : values) list += Integer(8, value);
  return Bytes(5, Bytes(1, name) + list + Integer(20, 7));
}

std::string TextAttribute(const std::string& name, const std::string& value) {
  return Bytes(5, Bytes(1, name) + Bytes(4, value) + Integer(20, 3));
}

std::string Constant(const std::string& output, const std::vector<std::int64_t>& numbers) {
  const std::string tensor =
      Integer(1, numbers.size()) + Integer(2, 7) + Bytes(9, WholeNumbers(numbers));
  return Node("Constant", {}, output,
              Bytes(5, Bytes(1, "value") + Bytes(5, tensor) + Integer(20, 4)));
}

std::string HalfTensor(const std::string& name, const std::vector<std::uint64_t>& sizes,
                       const std::vector<std::uint16_t>& halves) {
  std::string tensor;
  for (const std::uint64_t size : sizes) tensor += Integer(1, size);
  tensor += Integer(2, 10) + Bytes(8, name) +
            Bytes(9, {reinterpret_cast<const char*>(halves.data()), halves.size() * 2});
  return Bytes(5, tensor);
}

std::string Port(std::uint32_t field, const std::string& name, int channels, int side) {
  std::string shape;
  for (const int size : {1, channels, side, side})
    shape += Bytes(1, Integer(1, static_cast<std::uint64_t>(size)));
  return Bytes(field, Bytes(1, name) + Bytes(2, Bytes(1, Integer(1, 1) + Bytes(2, shape))));
}

constexpr std::uint16_t kOne = 0x3c00, kMinusTwo = 0xc000, kHalf = 0x3800, kSmallest = 0x0001;

/// y = upsampled(1 r - 2 g + 0.5 b + 2^-24) of an 8 x 8 picture, in halves; a second output that
/// needs an operation which OpenCV does not know.
std::string HalfNetwork() {
  std::string graph;
  graph += Node("Cast", {"input"}, "half", NumberAttribute("to", 10));
  graph += Node("Conv", {"half", "weights", "bias"}, "mixed",
                ListAttribute("kernel_shape", {1, 1}) + ListAttribute("strides", {2, 2}) +
                    ListAttribute("pads", {0, 0, 0, 0}) + ListAttribute("dilations", {1, 1}) +
                    NumberAttribute("group", 1));
  graph += Node("Shape", {"mixed"}, "sizes") + Constant("0", {0}) + Constant("2", {2});
  graph += Node("Slice", {"sizes", "0", "2"}, "first") + Constant("full", {8, 8});
  graph += Node("Concat", {"first", "full"}, "wanted", NumberAttribute("axis", 0));
  graph += Node("Cast", {"mixed"}, "single", NumberAttribute("to", 1));
  graph += Node("Resize", {"single", "", "", "wanted"}, "large",
                TextAttribute("mode", "linear") +
                    TextAttribute("coordinate_transformation_mode", "half_pixel"));
  graph += Node("Cast", {"large"}, "half_large", NumberAttribute("to", 10));
  graph += Node("Cast", {"half_large"}, "output", NumberAttribute("to", 1));
  graph += Node("NoSuchOperation", {"half_large"}, "side");
  graph += HalfTensor("weights", {1, 3, 1, 1}, {kOne, kMinusTwo, kHalf});
  graph += HalfTensor("bias", {1}, {kSmallest});
  graph += Port(11, "input", 3, 8) + Port(12, "output", 1, 8) + Port(12, "side", 1, 8);
  return Integer(1, 8) + Bytes(7, graph) + Bytes(8, Integer(2, 15));
}

cv::Mat OutputFor(const std::string& network, int side) {
  cv::dnn::Net net = cv::dnn::readNetFromONNX(network.data(), network.size());
  const int sizes[] = {1, 3, side, side};
  cv::Mat input(4, sizes, CV_32F);
  for (int channel = 0; channel < 3; ++channel)
    for (int i = 0; i < side * side; ++i)
      input.ptr<float>(0, channel)[i] = static_cast<float>(channel + 1);
  net.setInput(input);
  return net.forward().clone();
}

class SinglePrecisionNetworkOfSide : public ::testing::TestWithParam<int> {};
INSTANTIATE_TEST_SUITE_P(Sides, SinglePrecisionNetworkOfSide, ::testing::Values(8, 4, 16));

TEST_P(SinglePrecisionNetworkOfSide, RunsInOpenCvAndGivesWhatTheWeightsSay) {
  const int side = GetParam();
  const cv::Mat output = OutputFor(SinglePrecisionNetwork(HalfNetwork(), side), side);
  ASSERT_EQ(output.dims, 4);
  EXPECT_EQ(output.size[2], side);
  EXPECT_EQ(output.size[3], side);
  // 1 - 2 x 2 + 0.5 x 3; the bias is lost in single precision.
  for (int i = 0; i < side * side; ++i) EXPECT_EQ(output.ptr<float>()[i], -1.5F);
}

TEST(SinglePrecisionNetwork, WeightsKeepTheirValuesExactly) {
  const std::string network = SinglePrecisionNetwork(HalfNetwork(), 8);
  for (const float value : {1.0F, -2.0F, 0.5F, 0x1p-24F}) {
    const std::string bytes(reinterpret_cast<const char*>(&value), 4);
    EXPECT_NE(network.find(bytes), std::string::npos) << value;
  }
  EXPECT_EQ(network.find("Cast"), std::string::npos);
  EXPECT_EQ(network.find("NoSuchOperation"), std::string::npos) << "only the side output needs it";
}

TEST(SinglePrecisionNetwork, TruncatedFileIsRefused) {
  const std::string network = HalfNetwork();
  for (const std::size_t kept : {std::size_t{1}, std::size_t{5}, network.size() / 2})
    EXPECT_THROW(SinglePrecisionNetwork(network.substr(0, kept), 8), InputError) << kept;
}

TEST(SinglePrecisionNetwork, FileWithoutAGraphIsRefused) {
  EXPECT_THROW(SinglePrecisionNetwork("", 8), InputError);
  EXPECT_THROW(SinglePrecisionNetwork(Integer(1, 8) + Bytes(7, ""), 8), InputError);
}

}  // namespace keypose::capture::single_precision_test
