// Goes through the frames of a film.

export function FrameSlider(props: { frames: number; frame: number; set: (frame: number) => void }) {
  const last = props.frames - 1
  return (
    <div class="films-frame">
      <button
        aria-label="A frame back"
        disabled={props.frame === 0}
        onClick={() => props.set(props.frame - 1)}
      >
        ‹
      </button>
      <input
        type="range"
        aria-label="Frame"
        min={0}
        max={last}
        value={props.frame}
        onInput={(event) => props.set(Number(event.currentTarget.value))}
      />
      <button
        aria-label="A frame on"
        disabled={props.frame === last}
        onClick={() => props.set(props.frame + 1)}
      >
        ›
      </button>
      <span class="number small">
        {props.frame} / {last}
      </span>
    </div>
  )
}
