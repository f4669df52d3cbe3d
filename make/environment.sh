#!/bin/sh
# Check all requirements of a build before anything is built, and make the virtual environment unless it is sound.
# Usage: environment.sh FOLDER [PYTHON]. The stamp FOLDER/.python changes only when the environment was made.
set -u
venv=$1
asked=${2:-}

# A program that prints facts of a Python: version, whether it is new enough, has venv, has headers, and its path.
probe='import os, sys, sysconfig
try:
    import ensurepip, venv
except ImportError:
    venv = None
header = os.path.join(sysconfig.get_path("include"), "Python.h")
facts = sys.version_info[:3] + (sys.version_info >= (3, 11), bool(venv), os.path.exists(header))
print("%d.%d.%d %s %s %s" % facts + " " + getattr(sys, "_base_executable", sys.executable))'

find_python() { # the first Python that is new enough
    old=
    for python in ${asked:-python3 python3.14 python3.13 python3.12 python3.11}; do
        facts=$("$python" -c "$probe" 2>/dev/null) || continue
        read -r version new has_venv has_headers executable <<EOF
$facts
EOF
        [ "$new" = True ] && return
        old=${old:-": $python is Python $version"}
    done
    return 1
}

missing= packages=
need() { # SENTENCE PACKAGE...
    missing="$missing  $1
"
    shift
    packages="$packages $*"
}

check_machine() {
    if find_python; then
        [ "$has_venv" = True ] || need "The module venv of $python ($version) is missing." "${python##*/}-venv"
        [ "$has_headers" = True ] || need "The headers of $python ($version), Python.h, are missing." "${python##*/}-dev"
    else
        [ -z "$old" ] && name=python3 || name=python3.11
        need "Python 3.11 or later is missing$old." "$name" "$name-venv" "$name-dev"
    fi
    compiler=${CXX:-$(command -v c++ || command -v g++ || command -v clang++)}
    if [ -z "$compiler" ]; then
        [ "$(uname)" = Linux ] || need "A C++ compiler is missing." g++
    elif ! printf '#include <bit>\n#include <concepts>\n' | $compiler -std=c++20 -fsyntax-only -x c++ - 2>/dev/null; then
        need "The C++ compiler $compiler does not run or does not know C++20; GCC knows it from version 11 on." g++
    fi
    [ -z "$missing" ] && return
    printf 'make: hypertuna cannot be built here yet.\n%s' "$missing" >&2
    printf '  On Debian and Ubuntu: sudo apt-get install%s\n' "$packages" >&2
    return 1
}

# Without a compiler, write programs for CMake that call Zig's (ziglang from PyPI), for any processor of this kind.
write_compiler() { # PREFIX
    echo "make: no C++ compiler is installed: Zig's, from PyPI (ziglang), compiles instead" >&2
    zig="ZIG_GLOBAL_CACHE_DIR='$PWD/build/zig' ZIG_LOCAL_CACHE_DIR='$PWD/build/zig' exec '$1/bin/python' -m ziglang"
    for tool in "c++ -target $(uname -m)-linux-gnu.2.17 -O3 -fno-sanitize=undefined" ar ranlib; do
        printf '#!/bin/sh\n%s %s "$@"\n' "$zig" "$tool" >"$venv/bin/${tool%% *}"
        chmod +x "$venv/bin/${tool%% *}"
    done
}

# Print Python and folder of the environment, if it runs. The stamp holds this line, as an environment cannot be moved.
state() {
    "$venv/bin/python" -c 'import sys, pip
print("%d.%d" % sys.version_info[:2], sys.prefix)' 2>/dev/null
}

fault_of() { # STATE: why the environment cannot be kept, or nothing
    case ${1%% *} in
    '') echo "is broken" ;;
    2.* | 3.[0-9] | 3.10) echo "is of Python ${1%% *}" ;;
    *)
        if [ -e "$venv/.python" ] && [ "$1" != "$(cat "$venv/.python")" ]; then
            echo "was made in another folder or by another Python"
        elif [ -n "$asked" ] && [ "${1%% *}" != "$("$asked" -c 'import sys; print("%d.%d" % sys.version_info[:2])')" ]; then
            echo "is of Python ${1%% *}"
        fi
        ;;
    esac
}

now=$(state)
fault=$(fault_of "$now")
[ -z "$fault" ] && [ -e "$venv/.python" ] && exit
check_machine || exit 1
if [ -n "$fault" ]; then
    [ -e "$venv" ] && echo "make: $venv $fault and is made again" >&2
    echo "make: virtual environment $venv of Python $version" >&2
    "$executable" -m venv --clear "$venv" && now=$(state) || exit 1
fi
[ -n "$compiler" ] || write_compiler "${now#* }"
echo "$now" >"$venv/.python"
