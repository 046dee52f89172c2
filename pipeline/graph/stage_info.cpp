#include "pipeline/graph/stage_info.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <nlohmann/json.hpp>

#include "core/io/text/files.h"
#include "core/values/errors.h"
#include "core/values/file_names.h"

namespace keypose::pipeline {
namespace {

using nlohmann::json;

template <class Item>
const Item* FindNamed(const std::vector<Item>& items, const std::string& name) {
  const auto it =
      std::find_if(items.begin(), items.end(), [&](const Item& item) { return item.name == name; });
  return it == items.end() ? nullptr : &*it;
}

PortInfo ParsePort(const json& value, bool output) {
  PortInfo port;
  port.name = value.at("name").get<std::string>();
  port.kind = value.value("kind", "file");
  port.optional = value.value("optional", false);
  port.repeatable = value.value("repeatable", false);
  port.file = value.value("file", "");
  if (port.kind != "file" && port.kind != "folder" && port.kind != "path")
    throw std::runtime_error(fmt::format("port '{}' has kind '{}'", port.name, port.kind));
  if (output && port.kind == "path")
    throw std::runtime_error(
        fmt::format("the output '{}' has kind 'path'; use file or folder", port.name));
  if (output && port.file.empty()) port.file = port.name;
  if (output && (!IsOneName(port.file) || port.file == "manifest.json" ||
                 port.file == "report.json" || port.file == "log.txt"))
    throw std::runtime_error(fmt::format(
        "the file '{}' of an output is not a plain name, or is a name that the cache itself uses",
        port.file));
  return port;
}

MeasurementInfo ParseMeasurement(const json& value) {
  MeasurementInfo info;
  info.key = value.at("key").get<std::string>();
  info.label = value.value("label", info.key);
  info.unit = value.value("unit", "");
  const json good = value.value("good", json::object());
  if (good.contains("min")) info.good_min = good.at("min").get<double>();
  if (good.contains("max")) info.good_max = good.at("max").get<double>();
  return info;
}

std::string TextOf(const json& value) {
  if (value.is_string()) return value.get<std::string>();
  return value.dump();
}

OptionInfo ParseOption(const json& value) {
  OptionInfo option;
  option.name = value.at("name").get<std::string>();
  option.type = value.at("type").get<std::string>();
  option.unit = value.value("unit", "");
  if (value.contains("min") && value["min"].is_number()) option.min = value["min"].get<double>();
  if (value.contains("max") && value["max"].is_number()) option.max = value["max"].get<double>();
  if (value.contains("choices") && value["choices"].is_array())
    option.choices = value["choices"].get<std::vector<std::string>>();
  if (option.type != "bool" && option.type != "int" && option.type != "double" &&
      option.type != "string") {
    throw std::runtime_error(fmt::format("option '{}' has type '{}'", option.name, option.type));
  }
  option.default_value = CanonicalOption(option, TextOf(value.at("default")));
  return option;
}

template <class Number>
std::optional<Number> Parse(const std::string& text) {
  Number number{};
  const char* begin = text.data() + (text.starts_with('+') ? 1 : 0);
  const auto [end, error] = std::from_chars(begin, text.data() + text.size(), number);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return number;
}

std::string RangeText(const OptionInfo& option) {
  const std::string unit = option.unit.empty() ? "" : " " + option.unit;
  if (option.min && option.max)
    return fmt::format("between {} and {}{}", *option.min, *option.max, unit);
  if (option.min) return fmt::format("at least {}{}", *option.min, unit);
  return fmt::format("at most {}{}", *option.max, unit);
}

void CheckRange(const OptionInfo& option, double value, const std::string& text) {
  if ((option.min && value < *option.min) || (option.max && value > *option.max)) {
    throw UsageError(
        fmt::format("option '{}' is {}, but it must be {}", option.name, text, RangeText(option)));
  }
}

std::string CanonicalBool(const OptionInfo& option, const std::string& given) {
  const std::string text = LowerCase(given);
  if (text == "true" || text == "yes" || text == "on" || text == "1") return "true";
  if (text == "false" || text == "no" || text == "off" || text == "0") return "false";
  throw UsageError(
      fmt::format("option '{}' is '{}', but it must be true or false", option.name, text));
}

std::string CanonicalInt(const OptionInfo& option, const std::string& text) {
  const auto value = Parse<long long>(text);
  if (!value)
    throw UsageError(
        fmt::format("option '{}' is '{}', but it must be a whole number", option.name, text));
  CheckRange(option, static_cast<double>(*value), text);
  return std::to_string(*value);
}

std::string CanonicalDouble(const OptionInfo& option, const std::string& text) {
  const auto value = Parse<double>(text);
  if (!value || !std::isfinite(*value)) {
    throw UsageError(
        fmt::format("option '{}' is '{}', but it must be a number", option.name, text));
  }
  CheckRange(option, *value, text);
  return fmt::format("{}", *value);
}

}  // namespace

const PortInfo* StageInfo::FindInput(const std::string& name) const {
  return FindNamed(inputs, name);
}
const PortInfo* StageInfo::FindOutput(const std::string& name) const {
  return FindNamed(outputs, name);
}
const OptionInfo* StageInfo::FindOption(const std::string& name) const {
  return FindNamed(options, name);
}

StageInfo ParseStageInfo(const std::string& text, const std::string& program) {
  try {
    const json value = json::parse(text);
    if (value.at("schema").get<int>() != 1) throw std::runtime_error("schema is not 1");
    StageInfo info;
    info.stage = value.at("stage").get<std::string>();
    info.version = TextOf(value.at("version"));
    info.summary = value.value("summary", "");
    info.title = value.value("title", info.stage);
    for (const json& one : value.value("measurements", json::array()))
      info.measurements.push_back(ParseMeasurement(one));
    for (const json& port : value.at("inputs")) info.inputs.push_back(ParsePort(port, false));
    for (const json& port : value.at("outputs")) info.outputs.push_back(ParsePort(port, true));
    for (const json& option : value.value("options", json::array()))
      info.options.push_back(ParseOption(option));
    for (const json& tool : value.value("tools", json::array()))
      info.tools[tool.at("name").get<std::string>()] = TextOf(tool.at("version"));
    const json resources = value.value("resources", json::object());
    for (std::size_t i = 0; i < info.outputs.size(); ++i) {
      for (std::size_t j = 0; j < i; ++j) {
        if (info.outputs[i].file == info.outputs[j].file)
          throw std::runtime_error(
              fmt::format("two outputs have the file '{}'", info.outputs[i].file));
      }
    }
    info.cores = resources.value("cores", 0);
    info.memory_bytes =
        static_cast<std::int64_t>(std::clamp(resources.value("memory_bytes", 0.0), 0.0, 1e15));
    return info;
  } catch (const std::exception& error) {
    throw ToolError(
        fmt::format("{}: what `--describe` prints is not the stage contract's JSON: {}; see "
                    "docs/stage-contract.md",
                    program, JsonFault(error)));
  }
}

std::string CanonicalOption(const OptionInfo& option, const std::string& text) {
  if (option.type == "bool") return CanonicalBool(option, text);
  if (option.type == "int") return CanonicalInt(option, text);
  if (option.type == "double") return CanonicalDouble(option, text);
  if (!option.choices.empty() &&
      std::find(option.choices.begin(), option.choices.end(), text) == option.choices.end()) {
    throw UsageError(fmt::format("option '{}' is '{}', but it must be one of {}", option.name, text,
                                 fmt::join(option.choices, ", ")));
  }
  return text;
}

const OptionInfo& OptionOf(const StageInfo& info, const std::string& name) {
  if (const OptionInfo* option = info.FindOption(name)) return *option;
  std::vector<std::string> known;
  for (const OptionInfo& option : info.options) known.push_back(option.name);
  throw UsageError(
      fmt::format("stage '{}' has no option '{}'{}", info.stage, name, Suggestion(name, known)));
}

std::string Suggestion(const std::string& word, const std::vector<std::string>& known) {
  if (known.empty()) return "; there is none";
  const std::string nearest = fmt::format("; did you mean '{}'?", NearestWord(word, known));
  return known.size() > 12 ? nearest
                           : fmt::format("{} (known: {})", nearest, fmt::join(known, ", "));
}

}  // namespace keypose::pipeline
