/// FMI 2.0 for co-simulation. The declarations are those of the standard (fmi-standard.org) that are needed.
#include "fmu.hpp"

#ifdef _WIN32
#define FMI2 extern "C" __declspec(dllexport)
#else
#define FMI2 extern "C" __attribute__((visibility("default")))
#endif

using namespace hypertuna;

namespace {

using Logger = void (*)(void* environment, const char* instance, int status, const char* category, const char* text,
                        ...);
struct Callbacks {
    Logger logger;
    void* (*allocate)(std::size_t, std::size_t);
    void (*free)(void*);
    void (*finished)(void*, int);
    void* environment;
};

/// Convert the URI of a file into a path.
std::string path_of(const char* uri) {
    std::string text = uri ? uri : "";
    if (text.rfind("file:", 0) != 0) return text;
    text.erase(0, 5);
    if (text.rfind("//", 0) == 0) text.erase(0, text.find('/', 2));  // remove the host's name
    std::string path;
    for (std::size_t k = 0; k < text.size(); ++k) {
        unsigned code;
        const bool coded = text[k] == '%' && std::sscanf(text.substr(k + 1, 2).c_str(), "%2x", &code) == 1;
        path += coded ? char(code) : text[k];
        k += coded ? 2 : 0;
    }
    if (path.size() > 2 && path[0] == '/' && path[2] == ':') path.erase(0, 1);  // a drive letter of Windows
    return path;
}

}  // namespace

FMI2 const char* fmi2GetTypesPlatform() { return "default"; }
FMI2 const char* fmi2GetVersion() { return "2.0"; }
FMI2 int fmi2SetDebugLogging(void*, int, std::size_t, const char* const*) { return ok; }

FMI2 void* fmi2Instantiate(const char* name, int kind, const char* token, const char* resources,
                           const Callbacks* callbacks, int, int) {
    const Callbacks calls = *callbacks;
    const std::string own = name ? name : "";
    const auto tell = [calls, own](const std::string& sentence) {
        if (calls.logger) calls.logger(calls.environment, own.c_str(), error, "logStatusError", "%s", sentence.c_str());
    };
    if (kind != 1) {
        tell("kind: this FMU is for co-simulation");
        return nullptr;
    }
    return Fmu::load(path_of(resources), token, tell).release();
}
FMI2 int fmi2SetupExperiment(void* instance, int, double, double start, int, double) {
    of(instance).start_at(start);
    return ok;
}
FMI2 int fmi2EnterInitializationMode(void* instance) {
    of(instance).phase = Phase::initializing;
    return ok;
}

FMI2 int fmi2GetReal(void* c, const Reference* r, std::size_t n, double* v) { return get(c, r, n, 'r', v); }
FMI2 int fmi2GetInteger(void* c, const Reference* r, std::size_t n, int* v) { return get(c, r, n, 'i', v); }
FMI2 int fmi2GetBoolean(void* c, const Reference* r, std::size_t n, int* v) { return get(c, r, n, 'b', v); }
FMI2 int fmi2GetString(void* c, const Reference*, std::size_t n, const char**) { return n ? missing(c) : ok; }
FMI2 int fmi2SetReal(void* c, const Reference* r, std::size_t n, const double* v) { return set(c, r, n, 'r', v); }
FMI2 int fmi2SetInteger(void* c, const Reference* r, std::size_t n, const int* v) { return set(c, r, n, 'i', v); }
FMI2 int fmi2SetBoolean(void* c, const Reference* r, std::size_t n, const int* v) { return set(c, r, n, 'b', v); }
FMI2 int fmi2SetString(void* c, const Reference*, std::size_t n, const char* const*) { return n ? missing(c) : ok; }

COMMON(FMI2, fmi2, state, DeSerialize)

FMI2 int fmi2DoStep(void* instance, double at, double size, int) { return good(of(instance).step(at, size)); }

// Functions that the description declares as unsupported.
FMI2 int fmi2GetDirectionalDerivative(void* c, const Reference*, std::size_t, const Reference*, std::size_t,
                                      const double*, double*) {
    return missing(c);
}
FMI2 int fmi2SetRealInputDerivatives(void* c, const Reference*, std::size_t, const int*, const double*) {
    return missing(c);
}
FMI2 int fmi2GetRealOutputDerivatives(void* c, const Reference*, std::size_t, const int*, double*) {
    return missing(c);
}
FMI2 int fmi2CancelStep(void* c) { return missing(c); }
FMI2 int fmi2GetStatus(void* c, int, int*) { return missing(c); }
FMI2 int fmi2GetRealStatus(void* c, int what, double* value) {
    if (what != 2) return missing(c);  // the last successful time
    *value = of(c).time();
    return ok;
}
FMI2 int fmi2GetIntegerStatus(void* c, int, int*) { return missing(c); }
FMI2 int fmi2GetBooleanStatus(void* c, int what, int* value) {
    if (what != 3) return missing(c);  // terminated
    *value = of(c).phase == Phase::failed;
    return ok;
}
FMI2 int fmi2GetStringStatus(void* c, int, const char**) { return missing(c); }
