// Option visitors that turn a struct's fields into flags, JSON and checks. Used by stage_main.cpp
// only.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "core/values/options.h"

namespace keypose::internal {

/// A bound as JSON: null when there is none.
inline nlohmann::json Bound(double value) {
  return std::isfinite(value) ? nlohmann::json(value) : nlohmann::json(nullptr);
}

/// Lists options with their current values as defaults.
class DescribeVisitor final : public OptionVisitor {
 public:
  explicit DescribeVisitor(const std::vector<std::string>& common) : common_(common) {}
  void operator()(const char* name, bool& value, const OptionDoc& doc) override {
    Add(name, "bool", value, doc);
  }
  void operator()(const char* name, int& value, const OptionDoc& doc) override {
    Add(name, "int", value, doc);
  }
  void operator()(const char* name, double& value, const OptionDoc& doc) override {
    Add(name, "double", value, doc);
  }
  void operator()(const char* name, std::string& value, const OptionDoc& doc) override {
    Add(name, "string", value, doc);
  }
  nlohmann::json options = nlohmann::json::array();

 private:
  template <class T>
  void Add(const char* name, const char* type, const T& value, const OptionDoc& doc) {
    options.push_back({{"name", name},
                       {"type", type},
                       {"default", value},
                       {"unit", doc.unit},
                       {"min", Bound(doc.min)},
                       {"max", Bound(doc.max)},
                       {"choices", doc.choices},
                       {"common", std::find(common_.begin(), common_.end(), name) != common_.end()},
                       {"help", doc.help}});
  }
  const std::vector<std::string>& common_;
};

/// Collects the current values, by name.
class ValuesVisitor final : public OptionVisitor {
 public:
  void operator()(const char* name, bool& value, const OptionDoc&) override {
    values[name] = value;
  }
  void operator()(const char* name, int& value, const OptionDoc&) override { values[name] = value; }
  void operator()(const char* name, double& value, const OptionDoc&) override {
    values[name] = value;
  }
  void operator()(const char* name, std::string& value, const OptionDoc&) override {
    values[name] = value;
  }
  nlohmann::json values = nlohmann::json::object();
};

/// Collects one sentence for each value outside its range or choices.
class CheckVisitor final : public OptionVisitor {
 public:
  void operator()(const char*, bool&, const OptionDoc&) override {}
  void operator()(const char* name, int& value, const OptionDoc& doc) override {
    CheckRange(name, value, doc);
  }
  void operator()(const char* name, double& value, const OptionDoc& doc) override {
    CheckRange(name, value, doc);
  }
  void operator()(const char* name, std::string& value, const OptionDoc& doc) override {
    if (doc.choices.empty()) return;
    for (const std::string& choice : doc.choices)
      if (choice == value) return;
    problems.push_back(fmt::format("--{} is '{}', but must be one of: {}", name, value,
                                   fmt::join(doc.choices, ", ")));
  }
  std::vector<std::string> problems;

 private:
  void CheckRange(const char* name, double value, const OptionDoc& doc) {
    if (value >= doc.min && value <= doc.max) return;
    const auto text = [](double bound, const char* none) {
      return std::isfinite(bound) ? fmt::format("{:g}", bound) : std::string(none);
    };
    problems.push_back(fmt::format("--{} is {:g}, but must lie in [{}, {}]", name, value,
                                   text(doc.min, "-inf"), text(doc.max, "inf")));
  }
};

}  // namespace keypose::internal
