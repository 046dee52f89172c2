#include "pipeline/run/work_size.h"

// jpeglib.h needs size_t and FILE from here.
#include <csetjmp>
#include <cstdio>

#include <jpeglib.h>

#include <algorithm>
#include <set>

#include "core/io/pictures/photograph_files.h"
#include "core/values/errors.h"
#include "core/values/file_names.h"
#include "core/values/size_of.h"

namespace keypose::pipeline {
namespace {

namespace fs = std::filesystem;

struct JpegErrors {
  jpeg_error_mgr manager;
  std::jmp_buf back;
};

[[noreturn]] void GoBack(j_common_ptr info) {
  std::longjmp(reinterpret_cast<JpegErrors*>(info->err)->back, 1);
}
void SayNothing(j_common_ptr) {}

/// 0 if it is not a JPEG.
double JpegMegapixels(const std::string& content) {
  jpeg_decompress_struct info;
  JpegErrors errors;
  info.err = jpeg_std_error(&errors.manager);
  errors.manager.error_exit = GoBack;
  errors.manager.output_message = SayNothing;
  volatile double megapixels = 0;
  if (setjmp(errors.back) == 0) {
    jpeg_create_decompress(&info);
    jpeg_mem_src(&info, reinterpret_cast<const unsigned char*>(content.data()), content.size());
    if (jpeg_read_header(&info, TRUE) == JPEG_HEADER_OK)
      megapixels = 1e-6 * info.image_width * info.image_height;
  }
  jpeg_destroy_decompress(&info);
  return megapixels;
}

}  // namespace

double MegapixelsOf(const std::string& name, const std::string& content) {
  if (const double exact = JpegMegapixels(content); exact > 0) return exact;
  // Typical megabytes per megapixel of cameras and phones.
  const std::string extension = LowerExtension(name);
  const double megabytes = 1e-6 * static_cast<double>(content.size());
  if (IsHeicName(name)) return megabytes / 0.15;
  if (IsRawName(name)) return megabytes / 1.2;
  if (extension == ".png") return megabytes / 1.5;
  if (extension == ".tif" || extension == ".tiff") return megabytes / 3;
  return megabytes / 0.35;
}

WorkSize::WorkSize(const Graph& graph, const Disk& disk, fs::path project)
    : graph_(graph), disk_(disk), project_(std::move(project)) {}

WorkSize::Photographs WorkSize::In(const fs::path& folder) {
  if (const auto it = known_.find(folder); it != known_.end()) return it->second;
  std::vector<std::string> names = disk_.FilesBelow(project_ / folder);
  std::erase_if(names, [](const std::string& name) { return !IsShotName(name); });
  // RAW files count where there are no others.
  if (!std::all_of(names.begin(), names.end(), IsRawName))
    std::erase_if(names, [](const std::string& name) { return IsRawName(name); });
  Photographs found;
  found.count = SizeOf(names);
  const std::string first = names.empty() ? "" : names.front();
  try {
    if (!first.empty())
      found.megapixels = found.count * MegapixelsOf(first, disk_.Read(project_ / folder / first));
  } catch (const DiskError&) {
    // Ignored here: the stage that reads the file reports the error.
  }
  return known_[folder] = found;
}

double WorkSize::CoreSeconds(int step) {
  const auto& cost = graph_.steps[step].cost;
  if (!cost) return -1;
  std::set<int> seen = {step};
  std::set<fs::path> folders;
  std::vector<int> open = {step};
  while (!open.empty()) {
    const Step& at = graph_.steps[open.back()];
    open.pop_back();
    for (const PortFlows& port : at.inputs) {
      for (const Flow& flow : port.flows) {
        if (flow.photographs) folders.insert(flow.path);
      }
    }
    for (const int need : at.needs) {
      if (seen.insert(need).second) open.push_back(need);
    }
  }
  Photographs all;
  for (const fs::path& folder : folders) {
    const Photographs here = In(folder);
    all.count += here.count;
    all.megapixels += here.megapixels;
  }
  return cost->fixed + cost->photograph * all.count + cost->megapixel * all.megapixels;
}

}  // namespace keypose::pipeline
