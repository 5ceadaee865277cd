#include "tests/gpu/stand_in_runtime.hpp"

#include <sys/mman.h>

#include <cstdlib>
#include <cstring>
#include <deque>
#include <functional>
#include <map>
#include <random>

#include "common/base/error.hpp"
#include "rve-farm/cuda/cuda_kernels.hpp"
#include "tests/rve-farm/block/emulated_device.hpp"

struct CUstream_st {
    std::deque<std::function<void()>> waiting;
};

namespace talik::stand_in {
namespace {

class DeviceMemory {
public:
    static constexpr std::size_t size = std::size_t{4} << 30; // reserved, not taken
    DeviceMemory() : begin_(static_cast<std::byte*>(mmap(nullptr, size, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0))) { ensure(begin_ != MAP_FAILED); }
    ~DeviceMemory() { munmap(begin_, size); }

    std::byte* take(std::size_t bytes) {
        std::byte* const memory = begin_ + used_;
        used_ += (bytes + 255) / 256 * 256;
        ensure(used_ <= size);
        touch([&] { std::memset(memory, 0xff, bytes); }); // no numbers
        taken[memory] = bytes;
        return memory;
    }
    bool holds(const void* begin, std::size_t bytes) const {
        const auto after = taken.upper_bound(static_cast<const std::byte*>(begin));
        if (after == taken.begin()) return false;
        const auto& [memory, size_of_it] = *std::prev(after);
        return static_cast<const std::byte*>(begin) + bytes <= memory + size_of_it;
    }
    template <class Action>
    void touch(Action&& action) {
        ensure(mprotect(begin_, size, PROT_READ | PROT_WRITE) == 0);
        action();
        ensure(mprotect(begin_, size, PROT_NONE) == 0);
    }
    std::map<const std::byte*, std::size_t> taken;

private:
    std::byte* begin_;
    std::size_t used_ = 0;
};

struct State {
    Machine machine;
    std::unique_ptr<DeviceMemory> device = std::make_unique<DeviceMemory>();
    std::map<const std::byte*, std::size_t> locked;
    std::vector<cudaStream_t> streams;
    std::minstd_rand draw{7};
    int calls = 0, copies_of_other_memory = 0;
    std::string failed;
};
State state;

// The answer of a call of the runtime.
cudaError_t answer(const char* name) {
    const int now = state.calls++;
    if (state.machine.failing_call < 0 || now < state.machine.failing_call || (now > state.machine.failing_call && !state.machine.lost)) return cudaSuccess;
    if (state.failed.empty()) state.failed = name;
    return state.machine.error;
}

void work_off(CUstream_st& stream) {
    for (; !stream.waiting.empty(); stream.waiting.pop_front()) state.device->touch(stream.waiting.front());
}
void give(cudaStream_t stream, std::function<void()> work) {
    stream->waiting.push_back(std::move(work));
    if (state.machine.pace == Pace::at_once) work_off(*stream);
    if (state.machine.pace == Pace::at_random) work_off(*state.streams[state.draw() % state.streams.size()]);
}

bool is_locked(const void* begin, std::size_t bytes) {
    const auto after = state.locked.upper_bound(static_cast<const std::byte*>(begin));
    return after != state.locked.begin() && static_cast<const std::byte*>(begin) + bytes <= std::prev(after)->first + std::prev(after)->second;
}

cudaError_t launch(const char* name, const farm::BlockLaunch& launch, cudaStream_t stream) {
    if (const cudaError_t error = answer(name)) return error;
    const auto parameters = std::make_shared<RveParameters>(*launch.parameters); // as a kernel's: what they were at the launch
    ensure(state.device->holds(launch.tasks, sizeof(farm::BlockTask) * static_cast<std::size_t>(launch.blocks)));
    farm::BlockLaunch given = launch;
    given.parameters = parameters.get();
    give(stream, [given, parameters] { farm::EmulatedDevice().launch(0, given); });
    return cudaSuccess;
}

} // namespace

void set(const Machine& machine) {
    for (cudaStream_t stream : state.streams) delete stream;
    state = State();
    state.machine = machine;
}
int calls() { return state.calls; }
const std::string& failed() { return state.failed; }
int copies_of_other_memory() { return state.copies_of_other_memory; }
std::size_t bytes_taken() {
    std::size_t sum = 0;
    for (const auto* all : {&state.device->taken, &state.locked})
        for (const auto& [memory, bytes] : *all) sum += bytes;
    return sum;
}

} // namespace talik::stand_in

namespace talik::farm {
cudaError_t launch_single(const BlockLaunch& launch, cudaStream_t stream) { return stand_in::launch("launch_single", launch, stream); }
cudaError_t launch_double(const BlockLaunch& launch, cudaStream_t stream) { return stand_in::launch("launch_double", launch, stream); }
} // namespace talik::farm

using namespace talik::stand_in;

extern "C" {

cudaError_t cudaDriverGetVersion(int* version) { return *version = state.machine.driver, cudaSuccess; }
cudaError_t cudaRuntimeGetVersion(int* version) { return *version = 13000, cudaSuccess; }
cudaError_t cudaGetDeviceCount(int* count) {
    *count = state.machine.gpus;
    return state.machine.driver < 13000 ? cudaErrorInsufficientDriver : answer("cudaGetDeviceCount");
}
cudaError_t cudaDeviceGetAttribute(int* value, cudaDeviceAttr, int) { return *value = state.machine.compute_capability, answer("cudaDeviceGetAttribute"); }
cudaError_t cudaGetDeviceProperties(cudaDeviceProp* properties, int) {
    *properties = {};
    std::strcpy(properties->name, "Stand-in");
    properties->sharedMemPerBlockOptin = 227 * 1024;
    properties->sharedMemPerMultiprocessor = 228 * 1024;
    return answer("cudaGetDeviceProperties");
}
cudaError_t cudaSetDevice(int) { return answer("cudaSetDevice"); }
cudaError_t cudaMemGetInfo(std::size_t* free, std::size_t* all) { return *free = *all = state.machine.memory, answer("cudaMemGetInfo"); }

cudaError_t cudaMalloc(void** memory, std::size_t bytes) {
    if (const cudaError_t error = answer("cudaMalloc")) return error;
    return *memory = state.device->take(bytes), cudaSuccess;
}
cudaError_t cudaMallocHost(void** memory, std::size_t bytes) {
    if (const cudaError_t error = answer("cudaMallocHost")) return error;
    *memory = std::malloc(bytes);
    state.locked[static_cast<const std::byte*>(*memory)] = bytes;
    return cudaSuccess;
}
cudaError_t cudaFree(void* memory) { return state.device->taken.erase(static_cast<const std::byte*>(memory)), answer("cudaFree"); }
cudaError_t cudaFreeHost(void* memory) {
    state.locked.erase(static_cast<const std::byte*>(memory));
    std::free(memory);
    return answer("cudaFreeHost");
}

cudaError_t cudaStreamCreateWithFlags(cudaStream_t* stream, unsigned) {
    if (const cudaError_t error = answer("cudaStreamCreateWithFlags")) return error;
    state.streams.push_back(*stream = new CUstream_st);
    return cudaSuccess;
}
cudaError_t cudaStreamDestroy(cudaStream_t stream) {
    std::erase(state.streams, stream);
    delete stream;
    return answer("cudaStreamDestroy");
}
cudaError_t cudaStreamQuery(cudaStream_t stream) {
    if (const cudaError_t error = answer("cudaStreamQuery")) return error;
    return stream->waiting.empty() ? cudaSuccess : cudaErrorNotReady;
}
cudaError_t cudaGetLastError() { return cudaSuccess; }
cudaError_t cudaStreamSynchronize(cudaStream_t stream) {
    if (const cudaError_t error = answer("cudaStreamSynchronize")) return error;
    return work_off(*stream), cudaSuccess;
}
cudaError_t cudaMemcpyAsync(void* to, const void* from, std::size_t bytes, cudaMemcpyKind kind, cudaStream_t stream) {
    if (const cudaError_t error = answer("cudaMemcpyAsync")) return error;
    const bool in = kind == cudaMemcpyHostToDevice;
    ensure(state.device->holds(in ? to : from, bytes));
    state.copies_of_other_memory += !is_locked(in ? from : to, bytes);
    give(stream, [=] { std::memcpy(to, from, bytes); });
    return cudaSuccess;
}

const char* cudaGetErrorName(cudaError_t error) { return error == cudaErrorMemoryAllocation ? "cudaErrorMemoryAllocation" : "cudaErrorOther"; }
const char* cudaGetErrorString(cudaError_t error) { return error == cudaErrorMemoryAllocation ? "out of memory" : "unspecified failure"; }
}
