// A GPU as a Device.
#include <fmt/format.h>

#include <array>
#include <vector>

#include "common/base/error.hpp"
#include "common/base/log.hpp"
#include "rve-farm/cuda/cuda_calls.hpp"
#include "rve-farm/cuda/cuda_kernels.hpp"

namespace talik::farm {

void cuda_failed(cudaError_t error, const std::string& gpu, const std::string& doing) {
    const std::string remedy = error == cudaErrorMemoryAllocation ? "use fewer or smaller RVEs, more GPUs, or --backend cpu"
                                                                  : "see that the GPU is well (nvidia-smi), then go on from the last checkpoint, or with --backend cpu";
    fail(ExitCode::out_of_resource, fmt::format("{}: {} failed: {} ({})", gpu, doing, cudaGetErrorString(error), cudaGetErrorName(error)), remedy);
}

namespace {

class CudaDevice : public Device {
public:
    explicit CudaDevice(int number) : number_(number), name_(fmt::format("GPU {}", number)) {
        cudaDeviceProp properties;
        cuda_check(cudaGetDeviceProperties(&properties, number), name_, [] { return std::string("asking for its properties"); });
        name_ = fmt::format("GPU {} ({})", number, properties.name);
        shared_bytes_ = properties.sharedMemPerBlockOptin;
        shared_bytes_of_all_ = properties.sharedMemPerMultiprocessor;
        use();
        for (cudaStream_t& stream : streams_) check(cudaStreamCreateWithFlags(&stream, cudaStreamNonBlocking), "making a stream");
    }
    ~CudaDevice() override { // nothing can be done about what fails here
        cudaSetDevice(number_);
        for (std::byte* memory : memory_) cudaFree(memory);
        for (std::byte* memory : host_memory_) cudaFreeHost(memory);
        for (cudaStream_t stream : streams_)
            if (stream) cudaStreamDestroy(stream);
    }

    std::string name() const override { return name_; }
    std::size_t shared_bytes_of_a_block() const override { return shared_bytes_; }
    std::size_t shared_bytes_of_a_multiprocessor() const override { return shared_bytes_of_all_; }
    std::size_t free_bytes() const override {
        use();
        std::size_t free = 0, all = 0;
        check(cudaMemGetInfo(&free, &all), "asking for its memory");
        return free;
    }
    std::byte* allocate(std::size_t bytes, const std::string& purpose) override {
        use();
        void* memory = nullptr;
        cuda_check(cudaMalloc(&memory, bytes), name_, [&] { return fmt::format("taking {:.1f} MiB of its memory for {}", static_cast<double>(bytes) / (1 << 20), purpose); });
        memory_.push_back(static_cast<std::byte*>(memory));
        return memory_.back();
    }
    std::byte* allocate_on_host(std::size_t bytes, const std::string& purpose) override {
        use();
        void* memory = nullptr;
        cuda_check(cudaMallocHost(&memory, bytes), name_, [&] { return fmt::format("taking {:.1f} MiB of page-locked memory for {}", static_cast<double>(bytes) / (1 << 20), purpose); });
        host_memory_.push_back(static_cast<std::byte*>(memory));
        return host_memory_.back();
    }
    void copy_in(int stream, std::byte* device, const std::byte* host, std::size_t bytes) override {
        use();
        check(cudaMemcpyAsync(device, host, bytes, cudaMemcpyHostToDevice, stream_of(stream)), "copying to it");
    }
    void copy_out(int stream, std::byte* host, const std::byte* device, std::size_t bytes) override {
        use();
        check(cudaMemcpyAsync(host, device, bytes, cudaMemcpyDeviceToHost, stream_of(stream)), "copying from it");
    }
    void launch(int stream, const BlockLaunch& launch) override {
        use();
        const cudaError_t error = launch.precision == Precision::single_ ? launch_single(launch, stream_of(stream)) : launch_double(launch, stream_of(stream));
        cuda_check(error, name_, [&] { return fmt::format("launching {} blocks of {} threads and {} bytes of shared memory", launch.blocks, launch.threads, launch.shared_bytes); });
    }
    bool is_done(int stream) const override {
        use();
        const cudaError_t error = cudaStreamQuery(stream_of(stream));
        if (error != cudaErrorNotReady) check(error, "computing");
        cudaGetLastError(); // or the launch after it would find "not ready" there
        return error == cudaSuccess;
    }
    void wait(int stream) override {
        use();
        check(cudaStreamSynchronize(stream_of(stream)), "computing");
    }

private:
    void use() const { check(cudaSetDevice(number_), "taking it into use"); }
    void check(cudaError_t error, const char* doing) const {
        cuda_check(error, name_, [doing] { return std::string(doing); });
    }
    cudaStream_t stream_of(int stream) const { return streams_[static_cast<std::size_t>(stream)]; }

    int number_;
    std::string name_;
    std::size_t shared_bytes_ = 0, shared_bytes_of_all_ = 0;
    std::array<cudaStream_t, streams> streams_{};
    std::vector<std::byte*> memory_, host_memory_;
};

std::string version_in_words(int version) { return fmt::format("{}.{}", version / 1000, version % 1000 / 10); }

} // namespace

bool built_with_cuda() { return true; }

Gpus open_gpus() {
    int driver = 0, runtime = 0, count = 0;
    cudaDriverGetVersion(&driver); // 0 where there is none
    cudaRuntimeGetVersion(&runtime);
    if (driver == 0) return {{}, "no NVIDIA driver was found on this machine"};
    const cudaError_t error = cudaGetDeviceCount(&count);
    if (error == cudaErrorInsufficientDriver)
        return {{}, fmt::format("the NVIDIA driver is too old: it is for CUDA {}, this program was built with CUDA {}", version_in_words(driver), version_in_words(runtime))};
    if (error != cudaSuccess) return {{}, fmt::format("no GPU answers: {} ({})", cudaGetErrorString(error), cudaGetErrorName(error))};
    Gpus gpus;
    for (int number = 0; number < count; ++number) {
        // One that is taken by others, full or broken is left to itself: the rest may do.
        try {
            int major = 0;
            cuda_check(cudaDeviceGetAttribute(&major, cudaDevAttrComputeCapabilityMajor, number), fmt::format("GPU {}", number), [] { return std::string("asking for its compute capability"); });
            if (major >= 8) gpus.devices.push_back(std::make_shared<CudaDevice>(number));
        } catch (const Error& problem) {
            cudaGetLastError();
            gpus.reason = problem.problem();
        }
    }
    if (!gpus.reason.empty() && !gpus.devices.empty()) log::warn("{}; {} other GPUs are used", gpus.reason, gpus.devices.size());
    if (gpus.devices.empty() && gpus.reason.empty()) gpus.reason = count > 0 ? "the GPUs of this machine are older than compute capability 8.0" : "this machine has no GPU";
    return gpus;
}

} // namespace talik::farm
