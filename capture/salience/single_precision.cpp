#include "capture/salience/single_precision.h"

#include <array>
#include <bit>
#include <cstring>
#include <map>
#include <set>
#include <vector>

#include "capture/salience/protobuf_fields.h"
#include "core/values/errors.h"

namespace keypose::capture {
namespace {

// Numbers of fields in onnx.proto, as far as they are read here.
namespace model {
constexpr std::uint32_t kGraph = 7;
}
namespace graph {
constexpr std::uint32_t kNode = 1, kInitializer = 5, kInput = 11, kOutput = 12, kValueInfo = 13;
}
namespace node {
constexpr std::uint32_t kInput = 1, kOutput = 2, kOperation = 4, kAttribute = 5;
}
namespace attribute {
constexpr std::uint32_t kTensor = 5;
}
namespace tensor {
constexpr std::uint32_t kType = 2, kRaw = 9;
constexpr std::uint64_t kFloat = 1, kInt64 = 7, kHalf = 10;
}  // namespace tensor

struct Node {
  std::string_view message;
  std::string operation;
  std::vector<std::string> inputs;
  std::string output;  ///< the first
};

Node ReadNode(std::string_view message) {
  Node read{message, {}, {}, {}};
  for (const WireField& field : WireFields(message)) {
    if (field.number == node::kInput) read.inputs.emplace_back(field.bytes);
    if (field.number == node::kOutput && read.output.empty()) read.output = field.bytes;
    if (field.number == node::kOperation) read.operation = field.bytes;
  }
  return read;
}

/// IEEE 754 half to single; exact.
float SingleOf(std::uint16_t half) {
  const std::uint32_t sign = (half & 0x8000U) << 16;
  const std::uint32_t exponent = (half >> 10) & 31, fraction = half & 0x3ffU;
  if (exponent == 0) {  // zero and denormal numbers
    const float magnitude = static_cast<float>(fraction) * 0x1p-24F;
    return sign ? -magnitude : magnitude;
  }
  const std::uint32_t wide = exponent == 31 ? 255 : exponent + 112;
  return std::bit_cast<float>(sign | (wide << 23) | (fraction << 13));
}

std::string Singles(std::string_view halves) {
  std::string singles(halves.size() * 2, '\0');
  for (std::size_t i = 0; i + 1 < halves.size(); i += 2) {
    std::uint16_t half;
    std::memcpy(&half, halves.data() + i, 2);
    const float value = SingleOf(half);
    std::memcpy(singles.data() + i * 2, &value, 4);
  }
  return singles;
}

std::string SingleTensor(std::string_view message) {
  const std::vector<WireField> fields = WireFields(message);
  bool half = false;
  for (const WireField& field : fields)
    half |= field.number == tensor::kType && field.value == tensor::kHalf;
  if (!half) return std::string(message);
  std::string single;
  for (const WireField& field : fields) {
    if (field.number == tensor::kType)
      PutInteger(single, tensor::kType, tensor::kFloat);
    else if (field.number == tensor::kRaw)
      PutBytes(single, tensor::kRaw, Singles(field.bytes));
    else
      PutField(single, field);
  }
  return single;
}

/// A constant's message with its whole numbers times `scale`.
std::string ScaledTensor(std::string_view message, double scale) {
  std::string scaled;
  for (const WireField& field : WireFields(message)) {
    if (field.number != tensor::kRaw) {
      PutField(scaled, field);
      continue;
    }
    std::string numbers(field.bytes);
    for (std::size_t i = 0; i + 8 <= numbers.size(); i += 8) {
      std::int64_t number;
      std::memcpy(&number, numbers.data() + i, 8);
      number = static_cast<std::int64_t>(static_cast<double>(number) * scale);
      std::memcpy(numbers.data() + i, &number, 8);
    }
    PutBytes(scaled, tensor::kRaw, numbers);
  }
  return scaled;
}

/// name, type { tensor { element: float, shape: 1 x channels x side x side } }
std::string SquarePort(const std::string& name, int channels, int side) {
  std::string shape;
  for (const int size : {1, channels, side, side}) {
    std::string dimension;
    PutInteger(dimension, 1, static_cast<std::uint64_t>(size));
    PutBytes(shape, 1, dimension);
  }
  std::string array, type, port;
  PutInteger(array, 1, tensor::kFloat);
  PutBytes(array, 2, shape);
  PutBytes(type, 1, array);
  PutBytes(port, 1, name);
  PutBytes(port, 2, type);
  return port;
}

class Rewriting {
 public:
  Rewriting(std::string_view graph_message, int input_px) : fields_(WireFields(graph_message)) {
    for (const WireField& field : fields_) {
      if (field.number == graph::kNode) Take(ReadNode(field.bytes));
      if (field.number == graph::kInput && input_.empty()) TakeInput(field.bytes);
      if (field.number == graph::kOutput && output_.empty()) output_ = FirstText(field.bytes);
    }
    if (input_.empty() || output_.empty() || side_ <= 0)
      throw InputError("the network's file has no square input, or no output");
    scale_ = static_cast<double>(input_px) / side_;
    FindNeeded();
    FindSizes();
    input_px_ = input_px;
  }

  std::string Graph() const {
    std::string out;
    for (const WireField& field : fields_) {
      if (field.number == graph::kNode) {
        const Node read = ReadNode(field.bytes);
        if (read.operation != "Cast" && needed_.contains(read.output))
          PutBytes(out, graph::kNode, Rewritten(read));
      } else if (field.number == graph::kInitializer) {
        PutBytes(out, graph::kInitializer, SingleTensor(field.bytes));
      } else if (field.number != graph::kInput && field.number != graph::kOutput &&
                 field.number != graph::kValueInfo) {
        PutField(out, field);
      }
    }
    PutBytes(out, graph::kInput, SquarePort(input_, 3, input_px_));
    PutBytes(out, graph::kOutput, SquarePort(Source(output_), 1, input_px_));
    return out;
  }

 private:
  static std::string FirstText(std::string_view message) {
    for (const WireField& field : WireFields(message))
      if (field.number == 1) return std::string(field.bytes);
    return {};
  }

  void Take(Node read) {
    if (read.operation == "Cast" && read.inputs.size() == 1)
      source_[read.output] = read.inputs[0];
    else
      nodes_[read.output] = std::move(read);
  }

  /// The input's name and its side, the last of its sizes.
  void TakeInput(std::string_view port) {
    input_ = FirstText(port);
    for (const WireField& type : WireFields(port))
      if (type.number == 2)
        for (const WireField& array : WireFields(type.bytes))
          if (array.number == 1)
            for (const WireField& part : WireFields(array.bytes))
              if (part.number == 2) TakeSide(part.bytes);
  }

  void TakeSide(std::string_view shape) {
    for (const WireField& dimension : WireFields(shape))
      for (const WireField& size : WireFields(dimension.bytes))
        if (size.number == 1) side_ = static_cast<int>(size.value);
  }

  /// What a name stands for once the conversions are taken out.
  const std::string& Source(const std::string& name) const {
    const auto found = source_.find(name);
    return found == source_.end() ? name : Source(found->second);
  }

  void FindNeeded() {
    std::vector<std::string> open{Source(output_)};
    while (!open.empty()) {
      const std::string name = open.back();
      open.pop_back();
      const auto found = nodes_.find(name);
      if (found == nodes_.end() || !needed_.insert(name).second) continue;
      for (const std::string& input : found->second.inputs) open.push_back(Source(input));
    }
  }

  /// The constants that say how large the picture of a `Resize` becomes.
  void FindSizes() {
    for (const std::string& name : needed_) {
      const Node& resize = nodes_.at(name);
      if (resize.operation != "Resize" || resize.inputs.size() < 4) continue;
      const auto joined = nodes_.find(Source(resize.inputs[3]));
      if (joined == nodes_.end() || joined->second.operation != "Concat") continue;
      for (const std::string& part : joined->second.inputs) {
        const auto constant = nodes_.find(Source(part));
        if (constant != nodes_.end() && constant->second.operation == "Constant")
          sizes_.insert(constant->first);
      }
    }
  }

  std::string Rewritten(const Node& read) const {
    const bool is_size = sizes_.contains(read.output);
    std::string out;
    for (const WireField& field : WireFields(read.message)) {
      if (field.number == node::kInput)
        PutBytes(out, node::kInput, Source(std::string(field.bytes)));
      else if (is_size && field.number == node::kAttribute)
        PutBytes(out, node::kAttribute, ScaledAttribute(field.bytes));
      else
        PutField(out, field);
    }
    return out;
  }

  std::string ScaledAttribute(std::string_view message) const {
    std::string out;
    for (const WireField& field : WireFields(message)) {
      if (field.number == attribute::kTensor)
        PutBytes(out, attribute::kTensor, ScaledTensor(field.bytes, scale_));
      else
        PutField(out, field);
    }
    return out;
  }

  std::vector<WireField> fields_;
  std::map<std::string, Node> nodes_;  ///< by output; without conversions
  std::map<std::string, std::string> source_;
  std::set<std::string> needed_, sizes_;
  std::string input_, output_;
  int side_ = 0, input_px_ = 0;
  double scale_ = 1;
};

}  // namespace

std::string SinglePrecisionNetwork(std::string_view half, int input_px) {
  std::string single;
  bool found = false;
  for (const WireField& field : WireFields(half)) {
    if (field.number != model::kGraph) {
      PutField(single, field);
      continue;
    }
    found = true;
    PutBytes(single, model::kGraph, Rewriting(field.bytes, input_px).Graph());
  }
  if (!found) throw InputError("the network's file has no graph");
  return single;
}

}  // namespace keypose::capture
