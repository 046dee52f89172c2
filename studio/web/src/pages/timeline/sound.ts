// The sound to time against, as the browser decodes and plays it.

const kPeaksPerSecond = 200
const kSnippetSeconds = 0.09

/** Lowest and highest sample of each 1/200 s, in turn. */
function peaksOf(buffer: AudioBuffer): Float32Array {
  const samples = buffer.getChannelData(0)
  const width = buffer.sampleRate / kPeaksPerSecond
  const peaks = new Float32Array(2 * Math.ceil(samples.length / width))
  for (let i = 0; 2 * i < peaks.length; ++i) {
    const end = Math.min(samples.length, Math.floor((i + 1) * width))
    let low = 0
    let high = 0
    for (let at = Math.floor(i * width); at < end; ++at) {
      if (samples[at] < low) low = samples[at]
      if (samples[at] > high) high = samples[at]
    }
    peaks[2 * i] = low
    peaks[2 * i + 1] = high
  }
  return peaks
}

export class Sound {
  name = ''
  seconds = 0
  /** where on the timeline the sound begins [s] */
  offset = 0
  on = true
  peaks: Float32Array = new Float32Array(0)
  readonly peaksPerSecond = kPeaksPerSecond
  private context: AudioContext | null = null
  private buffer: AudioBuffer | null = null
  private source: AudioBufferSourceNode | null = null

  get there(): boolean {
    return this.buffer !== null
  }

  async load(file: Blob, name: string): Promise<void> {
    // An offline context decodes without the permission that playing needs.
    const decoder = new OfflineAudioContext(1, 1, 48000)
    try {
      this.buffer = await decoder.decodeAudioData(await file.arrayBuffer())
    } catch {
      throw new Error(`${name} is no sound that this browser can read; try WAV, MP3 or OGG.`)
    }
    this.name = name
    this.seconds = this.buffer.duration
    this.peaks = peaksOf(this.buffer)
  }

  clear(): void {
    this.stop()
    this.buffer = null
    this.name = ''
    this.peaks = new Float32Array(0)
  }

  /** Opens the output; browsers allow it only after a click or a key. */
  async wake(): Promise<void> {
    if (!this.buffer || !this.on) return
    this.context ??= new AudioContext()
    const late = new Promise((done) => setTimeout(done, 300))
    await Promise.race([this.context.resume(), late])
  }

  /** Plays from here on and is then the clock: the time at which it began, or null if silent. */
  start(seconds: number): number | null {
    this.stop()
    if (!this.buffer || !this.on || this.context?.state !== 'running') return null
    const within = seconds - this.offset
    if (within >= this.seconds) return null
    const began = this.context.currentTime
    this.source = this.sourceOf(this.buffer)
    this.source.start(began + Math.max(0, -within), Math.max(0, within))
    return began
  }

  /** Time of what is heard at this moment [s]: what was sent out a latency ago. */
  now(): number {
    return (this.context?.currentTime ?? 0) - (this.context?.outputLatency || 0)
  }

  stop(): void {
    this.source?.stop()
    this.source = null
  }

  /** A short piece, for scrubbing. */
  snippet(seconds: number): void {
    void this.wake().then(() => {
      const within = seconds - this.offset
      this.stop()
      if (!this.buffer || !this.on || within < 0 || within >= this.seconds) return
      if (this.context?.state !== 'running') return
      this.source = this.sourceOf(this.buffer)
      this.source.start(0, within, kSnippetSeconds)
    })
  }

  dispose(): void {
    this.stop()
    void this.context?.close()
    this.context = null
  }

  private sourceOf(buffer: AudioBuffer): AudioBufferSourceNode {
    const source = this.context!.createBufferSource()
    source.buffer = buffer
    source.connect(this.context!.destination)
    return source
  }
}
