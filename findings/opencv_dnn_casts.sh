#!/usr/bin/env bash
# OpenCV 4.6 runs networks that cast numbers to integers, but leaves the numbers as they are and says nothing; networks
# with weights in half precision it refuses.
#
# Seen with: Debian 12's python3-opencv 4.6.0+dfsg-12; networks by its python3-onnx 1.12.0-2+b4, whose checker (with
# inference of types) accepts all of them.
# Input: a convolution of 3 channels to 2, in single precision; the same with its result cast to INT32, and to UINT8, and
# back to FLOAT; and the same in half precision between two casts. ONNX says that such a cast cuts off the fraction.
# Output: the first is right to 1e-5. The casts to integers change nothing: results differ from the truth by up to
# 0.995, and none is a whole number. The last ends with "Unsupported data type: FLOAT16".
# Why it matters: networks that are published for browsers are often in half precision or quantised. The refusal is
# plain, and can be worked around. The casts are not: a network that counts, quantises or makes an index by one gives
# other results here than elsewhere, and nothing tells.
set -euo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
mkdir -p debs/partial root
apt-get -qq -y --no-install-recommends --reinstall --download-only -o Debug::NoLocking=1 \
  -o Dir::Cache::archives="$work/debs" install python3-opencv=4.6.0+dfsg-12 python3-numpy=1:1.24.2-1+deb12u1 \
  python3-onnx=1.12.0-2+b4 >apt.log 2>&1 || { cat apt.log; exit 2; }
for deb in debs/*.deb; do dpkg-deb -x "$deb" root; done
export PYTHONPATH="$work/root/usr/lib/python3/dist-packages"
libraries="$work/root/usr/lib/x86_64-linux-gnu"
export LD_LIBRARY_PATH="$libraries:$libraries/blas:$libraries/lapack"
/usr/bin/python3 - 2>messages <<'PY'
import sys
import cv2
import numpy as np
import onnx
from onnx import TensorProto, helper, numpy_helper

random = np.random.default_rng(0)
weights = random.uniform(0, 1, (2, 3, 3, 3)).astype(np.float16)
picture = random.uniform(0, 4, (1, 3, 8, 8)).astype(np.float16).astype(np.float32)
padded = np.pad(picture, ((0, 0), (0, 0), (1, 1), (1, 1)))
truth = sum(np.einsum("oc,nchw->nohw", weights[:, :, y, x].astype(np.float32), padded[:, :, y:y + 8, x:x + 8])
            for y in range(3) for x in range(3))

def cast(source, target, to):
    return helper.make_node("Cast", [source], [target], to=to)

def convolution(source, target):
    return helper.make_node("Conv", [source, "weights"], [target], kernel_shape=[3, 3], pads=[1, 1, 1, 1])

def result(nodes, kind):
    graph = helper.make_graph(nodes, "network",
                              [helper.make_tensor_value_info("in", TensorProto.FLOAT, [1, 3, 8, 8])],
                              [helper.make_tensor_value_info("out", TensorProto.FLOAT, [1, 2, 8, 8])],
                              [numpy_helper.from_array(weights.astype(kind), "weights")])
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 13)])
    model.ir_version = 7
    onnx.checker.check_model(model, full_check=True)
    onnx.save(model, "network.onnx")
    try:
        network = cv2.dnn.readNetFromONNX("network.onnx")
        network.setInput(picture)
        return network.forward()
    except cv2.error as error:
        return "refused: " + ("Unsupported data type: FLOAT16" if "data type: FLOAT16" in str(error) else str(error))

single = result([convolution("in", "out")], np.float32)
print(f"single precision: off by {abs(single - truth).max():.1e}, of {truth.max():.1f}")
same = abs(single - truth).max() < 1e-4
for name, kind in (("INT32", TensorProto.INT32), ("UINT8", TensorProto.UINT8)):
    whole = result([convolution("in", "a"), cast("a", "b", kind), cast("b", "out", TensorProto.FLOAT)], np.float32)
    off = abs(whole - np.trunc(truth)).max()
    print(f"cast to {name} and back: off by {off:.3f}; {np.mean(whole == np.round(whole)):.0%} are whole numbers")
    same = same and off > 0.5 and abs(whole - truth).max() < 1e-4
half = result([cast("in", "a", TensorProto.FLOAT16), convolution("a", "b"), cast("b", "out", TensorProto.FLOAT)],
              np.float16)
print("half precision:", half if isinstance(half, str) else f"off by {abs(half - truth).max():.1e}")
same = same and isinstance(half, str) and half.endswith("FLOAT16")
print("as before" if same else "CHANGED")
sys.exit(0 if same else 1)
PY
