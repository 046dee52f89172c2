// A film before and after: both show the same moment.
import { useEffect, useRef, useState } from 'preact/hooks'

import { useStudio } from '../../state'
import { useShortcuts } from '../timeline/shortcuts'
import { Pair, useZoom } from './pair'
import type { Mode } from './pair'
import { reviewApi } from './review_api'
import type { Version } from './review_api'
import { fileAt } from './review_model'

/** Of the film as a whole: so that every moment of it can be reached at once. */
function useFilm(url: string): string {
  const { complain } = useStudio()
  const [source, setSource] = useState('')
  useEffect(() => {
    if (!url) return
    let wanted = true
    let made = ''
    fetch(url)
      .then(async (answer) => {
        if (!answer.ok) throw new Error('The film is gone; look again.')
        const bytes = await answer.blob()
        if (!wanted) return
        made = URL.createObjectURL(bytes)
        setSource(made)
      })
      .catch((error) => wanted && complain(error))
    return () => {
      wanted = false
      setSource('')
      if (made) URL.revokeObjectURL(made)
    }
  }, [url])
  return source
}

/** Plays the second film, and puts the first where that is. */
function useTogether(fps: number) {
  const before = useRef<HTMLVideoElement>(null)
  const after = useRef<HTMLVideoElement>(null)
  const [time, setTime] = useState(0)
  const [length, setLength] = useState(0)
  const [playing, setPlaying] = useState(false)
  const both = () => [before.current, after.current].filter((film) => film !== null)
  const seek = (to: number) => {
    const frames = Math.max(1, Math.round(length * fps))
    const frame = Math.min(frames - 1, Math.max(0, Math.round(to * fps)))
    // The middle of the frame: its beginning may round to the one before.
    for (const film of both()) film.currentTime = (frame + 0.5) / fps
    setTime(frame / fps)
  }
  const measure = () =>
    setLength(Math.max(0, ...both().map((film) => (film.duration > 0 ? film.duration : 0))))
  const toggle = () => {
    if (playing) {
      for (const film of both()) film.pause()
      setPlaying(false)
      return seek(longest()?.currentTime ?? 0)
    }
    const from = time >= length - 1.5 / fps ? 0 : time
    for (const film of both()) film.currentTime = from
    setPlaying(true)
    for (const film of both()) void film.play().catch(() => setPlaying(false))
  }
  const longest = () => both().reduce<HTMLVideoElement | null>(
    (most, film) => (!most || film.duration > most.duration ? film : most),
    null,
  )
  useEffect(() => {
    if (!playing) return
    let next = 0
    const follow = () => {
      const lead = longest()
      if (lead?.ended) {
        setPlaying(false)
        return seek(length)
      }
      if (lead) setTime(Math.floor(lead.currentTime * fps) / fps)
      for (const film of both())
        if (lead && film !== lead && !film.ended)
          if (Math.abs(film.currentTime - lead.currentTime) > 1.5 / fps)
            film.currentTime = lead.currentTime
      next = requestAnimationFrame(follow)
    }
    next = requestAnimationFrame(follow)
    return () => cancelAnimationFrame(next)
  }, [playing, length])
  return { before, after, time, length, playing, seek, toggle, measure }
}

export function FilmPair(props: {
  path: string
  before: Version | null
  after: Version
  mode: Mode
  gain: number
}) {
  const { path, before, after } = props
  const { project } = useStudio()
  const { fps } = project
  const url = (version: Version | null) =>
    version ? reviewApi.fileUrl(fileAt(version, path)) : ''
  const first = useFilm(url(before))
  const second = useFilm(url(after))
  const { element, style, move } = useZoom(path)
  const films = useTogether(fps)
  const { time, length, playing, seek, toggle } = films
  const [heard, setHeard] = useState(false)
  useShortcuts({
    ' ': toggle,
    ',': () => seek(time - 1 / fps),
    '.': () => seek(time + 1 / fps),
    Home: () => seek(0),
    End: () => seek(length),
  })
  const film = (which: 'before' | 'after', source: string) => (
    <video
      ref={films[which]}
      src={source || undefined}
      aria-label={`${path}, ${which}`}
      muted={which === 'before' || !heard}
      playsInline
      preload="auto"
      style={style}
      onLoadedMetadata={films.measure}
      onLoadedData={() => seek(time)}
    />
  )
  const frames = Math.max(1, Math.round(length * fps))
  return (
    <div ref={element} class="rv-room" onPointerMove={move}>
      {before ? (
        <Pair
          mode={props.mode}
          gain={props.gain}
          before={film('before', first)}
          after={film('after', second)}
        />
      ) : (
        <div class="rv-pair">
          <div class="rv-layer">{film('after', second)}</div>
        </div>
      )}
      <div class="row rv-transport" role="toolbar" aria-label="Transport">
        <button onClick={toggle}>{playing ? 'Pause' : 'Play'}</button>
        <button aria-label="A frame back" onClick={() => seek(time - 1 / fps)}>
          ‹
        </button>
        <button aria-label="A frame on" onClick={() => seek(time + 1 / fps)}>
          ›
        </button>
        <input
          type="range"
          aria-label="Frame"
          min={0}
          max={frames - 1}
          value={Math.round(time * fps)}
          onInput={(event) => seek(Number(event.currentTarget.value) / fps)}
        />
        <span class="number small rv-reading">
          {Math.round(time * fps)} / {frames - 1} · {time.toFixed(2)} s
        </span>
        <button class="quiet" aria-pressed={heard} onClick={() => setHeard(!heard)}>
          Sound
        </button>
      </div>
    </div>
  )
}
