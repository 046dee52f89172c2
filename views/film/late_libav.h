// libav's functions under their own names, but of the late library keypose_films, since libav links
// some 90 libraries. Within this namespace a call finds these, not those of libav's headers.
#pragma once

extern "C" {
#include <libavcodec/avcodec.h>
#include <libavformat/avformat.h>
#include <libavutil/opt.h>
#include <libavutil/pixdesc.h>
#include <libswresample/swresample.h>
#include <libswscale/swscale.h>
}

#include <atomic>

namespace keypose {

/// @throws ToolError  libav cannot be loaded
void* FindInLibav(const char* function);

template <class Signature>
class LateFunction;

/// A function that is looked for when it is first called.
template <class Result, class... Arguments>
class LateFunction<Result(Arguments...)> {
 public:
  explicit constexpr LateFunction(const char* name) : name_(name) {}

  Result operator()(Arguments... arguments) const {
    void* address = address_.load(std::memory_order_relaxed);
    if (!address) address_ = address = FindInLibav(name_);
    return reinterpret_cast<Result (*)(Arguments...)>(address)(arguments...);
  }

 private:
  const char* name_;
  mutable std::atomic<void*> address_ = nullptr;
};

// A signature is not concerned with what its function's result is marked as.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wignored-attributes"
#define KEYPOSE_LATE(name) inline constinit const LateFunction<decltype(::name)> name(#name)
KEYPOSE_LATE(av_channel_layout_copy);
KEYPOSE_LATE(av_channel_layout_default);
KEYPOSE_LATE(av_channel_layout_uninit);
KEYPOSE_LATE(av_color_primaries_name);
KEYPOSE_LATE(av_color_space_name);
KEYPOSE_LATE(av_color_transfer_name);
KEYPOSE_LATE(av_d2q);
KEYPOSE_LATE(av_dict_free);
KEYPOSE_LATE(av_dict_get);
KEYPOSE_LATE(av_dict_set);
KEYPOSE_LATE(av_fourcc_make_string);
KEYPOSE_LATE(av_frame_alloc);
KEYPOSE_LATE(av_frame_free);
KEYPOSE_LATE(av_frame_get_buffer);
KEYPOSE_LATE(av_frame_get_side_data);
KEYPOSE_LATE(av_frame_make_writable);
KEYPOSE_LATE(av_get_packed_sample_fmt);
KEYPOSE_LATE(av_guess_sample_aspect_ratio);
KEYPOSE_LATE(av_interleaved_write_frame);
KEYPOSE_LATE(av_log_set_level);
KEYPOSE_LATE(av_opt_set);
KEYPOSE_LATE(av_opt_set_int);
KEYPOSE_LATE(av_packet_alloc);
KEYPOSE_LATE(av_packet_free);
KEYPOSE_LATE(av_packet_rescale_ts);
KEYPOSE_LATE(av_packet_unref);
KEYPOSE_LATE(av_pix_fmt_desc_get);
KEYPOSE_LATE(av_read_frame);
KEYPOSE_LATE(av_read_image_line2);
KEYPOSE_LATE(av_rescale_q);
KEYPOSE_LATE(av_sample_fmt_is_planar);
KEYPOSE_LATE(av_stream_get_side_data);
KEYPOSE_LATE(av_strerror);
KEYPOSE_LATE(av_write_trailer);
KEYPOSE_LATE(avcodec_alloc_context3);
KEYPOSE_LATE(avcodec_find_decoder);
KEYPOSE_LATE(avcodec_find_decoder_by_name);
KEYPOSE_LATE(avcodec_find_encoder);
KEYPOSE_LATE(avcodec_find_encoder_by_name);
KEYPOSE_LATE(avcodec_free_context);
KEYPOSE_LATE(avcodec_get_name);
KEYPOSE_LATE(avcodec_open2);
KEYPOSE_LATE(avcodec_parameters_from_context);
KEYPOSE_LATE(avcodec_parameters_to_context);
KEYPOSE_LATE(avcodec_receive_frame);
KEYPOSE_LATE(avcodec_receive_packet);
KEYPOSE_LATE(avcodec_send_frame);
KEYPOSE_LATE(avcodec_send_packet);
KEYPOSE_LATE(avformat_alloc_output_context2);
KEYPOSE_LATE(avformat_close_input);
KEYPOSE_LATE(avformat_find_stream_info);
KEYPOSE_LATE(avformat_free_context);
KEYPOSE_LATE(avformat_index_get_entries_count);
KEYPOSE_LATE(avformat_new_stream);
KEYPOSE_LATE(avformat_open_input);
KEYPOSE_LATE(avformat_write_header);
KEYPOSE_LATE(avio_closep);
KEYPOSE_LATE(avio_open);
KEYPOSE_LATE(sws_freeContext);
KEYPOSE_LATE(sws_getCoefficients);
KEYPOSE_LATE(sws_getContext);
KEYPOSE_LATE(sws_scale);
KEYPOSE_LATE(sws_setColorspaceDetails);
KEYPOSE_LATE(swr_alloc_set_opts2);
KEYPOSE_LATE(swr_convert);
KEYPOSE_LATE(swr_free);
KEYPOSE_LATE(swr_get_out_samples);
KEYPOSE_LATE(swr_init);
KEYPOSE_LATE(swr_set_matrix);
#undef KEYPOSE_LATE
#pragma GCC diagnostic pop

}  // namespace keypose
