/// FMI 3.0 for co-simulation. The declarations are those of the standard (fmi-standard.org) that are needed.
#include "fmu.hpp"

#ifdef _WIN32
#define FMI3 extern "C" __declspec(dllexport)
#else
#define FMI3 extern "C" __attribute__((visibility("default")))
#endif

using namespace hypertuna;

namespace {

using Log = void (*)(void* environment, int status, const char* category, const char* message);

void* refuse_kind(void* environment, Log log, const char* sentence) {
    if (log) log(environment, error, "logStatusError", sentence);
    return nullptr;
}

}  // namespace

FMI3 const char* fmi3GetVersion() { return "3.0"; }
FMI3 int fmi3SetDebugLogging(void*, bool, std::size_t, const char* const*) { return ok; }

FMI3 void* fmi3InstantiateCoSimulation(const char*, const char* token, const char* resources, bool, bool, bool, bool,
                                       const Reference*, std::size_t, void* environment, Log log, void*) {
    std::string folder = resources ? resources : "";
    while (!folder.empty() && (folder.back() == '/' || folder.back() == '\\')) folder.pop_back();
    const auto tell = [environment, log](const std::string& sentence) {
        if (log) log(environment, error, "logStatusError", sentence.c_str());
    };
    return Fmu::load(folder, token, tell).release();
}
FMI3 void* fmi3InstantiateModelExchange(const char*, const char*, const char*, bool, bool, void* environment, Log log) {
    return refuse_kind(environment, log, "kind: this FMU is for co-simulation");
}
FMI3 void* fmi3InstantiateScheduledExecution(const char*, const char*, const char*, bool, bool, void* environment,
                                             Log log, void*, void*, void*) {
    return refuse_kind(environment, log, "kind: this FMU is for co-simulation");
}
FMI3 int fmi3EnterInitializationMode(void* instance, bool, double, double start, bool, double) {
    of(instance).start_at(start);
    of(instance).phase = Phase::initializing;
    return ok;
}
#define VALUES(name, type, letter)                                                                   \
    FMI3 int fmi3Get##name(void* c, const Reference* r, std::size_t n, type* v, std::size_t) {       \
        return get(c, r, n, letter, v);                                                              \
    }                                                                                                \
    FMI3 int fmi3Set##name(void* c, const Reference* r, std::size_t n, const type* v, std::size_t) { \
        return set(c, r, n, letter, v);                                                              \
    }
VALUES(Float64, double, 'r')
VALUES(Int32, std::int32_t, 'i')
VALUES(Boolean, bool, 'b')

COMMON(FMI3, fmi3, State, Deserialize)

FMI3 int fmi3DoStep(void* instance, double at, double size, bool, bool* event, bool* terminate, bool* early,
                    double* last) {
    const FmiStatus status = good(of(instance).step(at, size));
    *event = *early = false;
    *terminate = of(instance).phase == Phase::failed;
    *last = of(instance).time();
    return status;
}

// Functions that the description declares as unsupported; calling conventions let them ignore their other arguments.
#define MISSING(name) \
    FMI3 int fmi3##name(void* c) { return missing(c); }
// clang-format off
MISSING(EnterEventMode) MISSING(EnterStepMode) MISSING(EnterConfigurationMode) MISSING(ExitConfigurationMode)
MISSING(GetFloat32) MISSING(GetInt8) MISSING(GetUInt8) MISSING(GetInt16) MISSING(GetUInt16) MISSING(GetUInt32)
MISSING(GetInt64) MISSING(GetUInt64) MISSING(GetString) MISSING(GetBinary) MISSING(GetClock) MISSING(SetFloat32)
MISSING(SetInt8) MISSING(SetUInt8) MISSING(SetInt16) MISSING(SetUInt16) MISSING(SetUInt32) MISSING(SetInt64)
MISSING(SetUInt64) MISSING(SetString) MISSING(SetBinary) MISSING(SetClock) MISSING(GetNumberOfVariableDependencies)
MISSING(GetVariableDependencies) MISSING(GetDirectionalDerivative) MISSING(GetAdjointDerivative)
MISSING(GetOutputDerivatives) MISSING(GetIntervalDecimal) MISSING(GetIntervalFraction) MISSING(GetShiftDecimal)
MISSING(GetShiftFraction) MISSING(SetIntervalDecimal) MISSING(SetIntervalFraction) MISSING(SetShiftDecimal)
MISSING(SetShiftFraction) MISSING(EvaluateDiscreteStates) MISSING(UpdateDiscreteStates)
MISSING(EnterContinuousTimeMode) MISSING(CompletedIntegratorStep) MISSING(SetTime) MISSING(SetContinuousStates)
MISSING(GetContinuousStateDerivatives) MISSING(GetEventIndicators) MISSING(GetContinuousStates)
MISSING(GetNominalsOfContinuousStates) MISSING(GetNumberOfEventIndicators) MISSING(GetNumberOfContinuousStates)
MISSING(ActivateModelPartition)
    // clang-format on
