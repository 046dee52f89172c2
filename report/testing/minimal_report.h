// A run with one pose and its report without measurements.
#pragma once

#include <gmock/gmock.h>

#include <filesystem>
#include <string>

#include "core/values/errors.h"
#include "core/values/mesh.h"
#include "report/evidence/contents.h"

namespace keypose::report {

inline Mesh Tetrahedron(double size = 1, double lift = 0) {
  Mesh mesh;
  mesh.points.resize(4, 3);
  mesh.points << 0, 0, lift, size, 0, lift, 0, size, lift, 0, 0, size + lift;
  mesh.faces.resize(4, 3);
  mesh.faces << 0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3;
  return mesh;
}

inline const char* const kRun =
    R"({"schema": 1, "project": {"name": "clay <dog>", "template": "rest", "poses": ["rest", "up"]}, "timeline": null, "steps": [
  {"id": "sfm/rest", "step": "sfm", "stage": "sfm", "pose": "rest", "status": "done", "seconds": 12.5, "peak_bytes": 400000000, "cached": true,
   "fingerprint": "abcdef0123456789", "report": "sfm.json", "outputs": {"model": "/nowhere/model"}, "inputs": {"images": ["images"]}},
  {"id": "cleanup/up", "step": "cleanup", "stage": "cleanup", "pose": "up", "status": "failed", "report": "gone.json"}]})";

inline std::string ReadFake(const std::filesystem::path& path) {
  if (path == "/base/sfm.json")
    return R"({"schema": 1, "stage": "sfm", "version": "3", "options": {"camera": "opencv"}, "seconds": 12.5, "peak_bytes": 4,
              "measurements": {"images_total": 36, "images_placed": 20, "reprojection_error_px": 0.51, "levelled": true, "note": "a < b", "unplaced": ["x.jpg"]}})";
  throw DiskError("cannot open " + path.string());
}

inline Contents Minimal() {
  Contents contents;
  contents.run = ParseRun(kRun, "/base", ReadFake);
  contents.poses.push_back({});
  contents.poses.back().name = "rest";
  return contents;
}

}  // namespace keypose::report
