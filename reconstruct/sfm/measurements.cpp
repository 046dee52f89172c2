#include "reconstruct/sfm/measurements.h"

#include <algorithm>
#include <type_traits>

#include "core/stage/stage.h"

namespace keypose::reconstruct {

void Measurements::Put(std::string_view name, Value value) {
  const auto same = [&](const auto& entry) { return entry.first == name; };
  const auto at = std::find_if(values_.begin(), values_.end(), same);
  if (at == values_.end())
    values_.emplace_back(name, std::move(value));
  else
    at->second = std::move(value);
}

const Measurements::Value* Measurements::Find(std::string_view name) const {
  for (const auto& [known, value] : values_)
    if (known == name) return &value;
  return nullptr;
}

void Measurements::Report(StageContext& stage) const {
  for (const auto& entry : values_) {
    const std::string& name = entry.first;
    const auto report = [&]<class T>(const T& value) {
      if constexpr (std::is_same_v<T, Json>)
        stage.ReportJson(name, value.text);
      else
        stage.Report(name, value);
    };
    std::visit(report, entry.second);
  }
  for (const std::string& sentence : warnings_) stage.Warn(sentence);
}

}  // namespace keypose::reconstruct
