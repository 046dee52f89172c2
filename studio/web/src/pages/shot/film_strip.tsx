// The film's frames in a row: which is shown, and which pose each of them shows.
import { useEffect, useRef } from 'preact/hooks'

import { shotApi } from './shot_api'
import type { Click, Film, Show } from './shot_api'

/** Frames with a pose, after one frame has got another; '' takes it away. */
export function withShow(shows: Show[], frame: number, pose: string): Show[] {
  const others = shows.filter((show) => show.frame !== frame)
  const all = pose ? [...others, { frame, pose }] : others
  return all.sort((one, two) => one.frame - two.frame)
}

export function FilmStrip(props: {
  film: Film
  poses: string[]
  clicks: readonly Click[]
  current: number
  choose: (frame: number) => void
  show: (frame: number, pose: string) => void
}) {
  const { film, current } = props
  const list = useRef<HTMLUListElement>(null)
  useEffect(() => {
    const button = list.current?.querySelector('[aria-current="true"]')
    button?.scrollIntoView({ block: 'nearest', inline: 'center' })
  }, [current])
  const poseOf = (frame: number) => film.shows.find((show) => show.frame === frame)?.pose ?? ''
  return (
    <nav class="shot-strip" aria-label="Frames of the film">
      <ul ref={list}>
        {film.frames.map(({ frame, name }) => {
          const pose = poseOf(frame)
          const clicks = props.clicks.filter((click) => click.frame === frame).length
          return (
            <li key={frame} class={pose ? 'shown' : ''}>
              <button
                aria-current={frame === current ? 'true' : undefined}
                aria-label={`Frame ${frame}${pose ? `, ${pose}` : ''}`}
                title={name}
                onClick={() => props.choose(frame)}
              >
                <img src={shotApi.frameUrl(frame, 240, film.film)} alt="" loading="lazy" />
                <span class="number">{frame}</span>
              </button>
              {clicks > 0 && <em title={`${clicks} clicks`}>{clicks}</em>}
              <select
                aria-label={`Pose of frame ${frame}`}
                value={pose}
                onChange={(event) => props.show(frame, event.currentTarget.value)}
              >
                <option value="">no pose</option>
                {props.poses.map((one) => (
                  <option key={one} value={one}>
                    {one}
                  </option>
                ))}
              </select>
            </li>
          )
        })}
      </ul>
    </nav>
  )
}
