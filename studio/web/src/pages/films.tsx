// The films of a performance: a frame of each camera, what was taken for the actor, and clicks and
// lines that say what he is.
import { useEffect, useState } from 'preact/hooks'

import { api } from '../api'
import type { Films } from '../api'
import { useKeys } from '../keys'
import { ShotPage } from '../shot_choice'
import { useStudio } from '../state'
import { SendFiles } from '../uploads/send_files'
import { FrameSlider } from './films/frame_slider'
import { noteOf } from './poses/figure_model'
import { FigureSide } from './poses/figure_side'
import type { FigureWords } from './poses/figure_side'
import { said, StrokeSheet, useFigureKeys } from './poses/figure_view'
import type { FigureTool } from './poses/figure_view'
import { resultsOf, useLoaded } from './poses/load'
import { Strip } from './poses/strip'
import { useFigure } from './poses/use_figure'
import './poses/poses.css'
import './films/films.css'

const kWords: FigureWords = {
  figure: 'the actor',
  picture: 'frame',
  help:
    'Needed only where the masks took something else for him, or lost a part. A click or a line in ' +
    'one frame is enough: the other frames of that camera follow.',
}

/** The place that "cam1/30" says. */
export function placeOf(picture: string): { camera: string; frame: number } {
  const slash = picture.lastIndexOf('/')
  return { camera: picture.slice(0, slash), frame: Number(picture.slice(slash + 1)) }
}

/** A value that has not changed for a moment: frames that a slider only passes are not decoded. */
function useSettled<T>(value: T): T {
  const [settled, setSettled] = useState(value)
  useEffect(() => {
    const timer = setTimeout(() => setSettled(value), 80)
    return () => clearTimeout(timer)
  }, [value])
  return settled
}

function ShotFilms({ shot, films }: { shot: string; films: Films }) {
  const { steps } = useStudio()
  const desk = useFigure(shot)
  const [tool, setTool] = useState<FigureTool>({ figure: true, masks: true })
  const [chosen, setChosen] = useState(films.cameras[0].name)
  const [wanted, setWanted] = useState(0)
  const names = films.cameras.map((one) => one.name)
  const camera = films.cameras.find((one) => one.name === chosen) ?? films.cameras[0]
  const at = Math.min(wanted, camera.frames - 1)
  const frame = Math.min(useSettled(at), camera.frames - 1)
  const results = resultsOf(steps, shot)
  const set = (next: number) => setWanted(Math.min(camera.frames - 1, Math.max(0, next)))
  const other = (by: number) => {
    const next = names[names.indexOf(camera.name) + by]
    if (next) setChosen(next)
  }
  useFigureKeys(tool, setTool, desk)
  useKeys({
    ',': () => set(at - 1),
    '.': () => set(at + 1),
    ArrowLeft: () => set(at - 1),
    ArrowRight: () => set(at + 1),
    Home: () => set(0),
    End: () => set(camera.frames - 1),
    PageUp: () => other(-1),
    PageDown: () => other(1),
  })
  const picture = `${camera.name}/${frame}`
  const { clicks } = desk.strokes
  return (
    <div class="figure-bench">
      <div class="figure-main">
        <StrokeSheet
          key={camera.name}
          picture={picture}
          src={api.filmUrl(shot, camera.name, frame)}
          mask={camera.masked ? api.filmMaskUrl(shot, camera.name, frame, results) : ''}
          width={camera.width}
          height={camera.height}
          label={`${shot}: ${picture}`}
          kind="Frame"
          tool={tool}
          strokes={clicks}
          add={(stroke) => said(desk, stroke)}
        />
        <FrameSlider frames={camera.frames} frame={at} set={set} />
        <Strip
          src={(one) => api.filmUrl(shot, one, frame, 240)}
          label={`Cameras of ${shot}`}
          names={films.cameras.filter((one) => frame < one.frames).map((one) => one.name)}
          current={camera.name}
          choose={setChosen}
          note={(one) => noteOf(clicks, `${one}/${frame}`)}
        />
      </div>
      <FigureSide
        words={kWords}
        desk={desk}
        tool={tool}
        change={setTool}
        name={picture}
        choose={(where) => {
          const place = placeOf(where)
          setChosen(place.camera)
          setWanted(place.frame)
        }}
      />
    </div>
  )
}

function AddFilms({ shot }: { shot: string }) {
  return (
    <SendFiles
      place="shot"
      shot={shot}
      folder
      words={`Drop films of ${shot}: a video of each camera, or its folder of numbered pictures.`}
    />
  )
}

/** Films of one more camera, or of one more shot. */
function MoreFilms({ shot }: { shot: string }) {
  const { reload, tell, complain } = useStudio()
  const [name, setName] = useState('')
  const add = () =>
    api.addShot(name).then(async () => {
      await reload()
      tell(`The shot ${name} is there; its films are missing yet.`)
      setName('')
    }, complain)
  return (
    <details class="films-more">
      <summary>More films</summary>
      <div class="stack">
        <AddFilms shot={shot} />
        <form
          class="row"
          onSubmit={(event) => {
            event.preventDefault()
            void add()
          }}
        >
          <input
            aria-label="Name of another shot"
            placeholder="another shot"
            value={name}
            onInput={(event) => setName(event.currentTarget.value)}
          />
          <button disabled={name.trim() === ''}>Add a shot</button>
        </form>
      </div>
    </details>
  )
}

function ShotPanel({ shot }: { shot: string }) {
  const { version } = useStudio()
  const { value: films } = useLoaded(() => api.films(shot), [shot, version])
  if (!films) return <div class="empty">Opens the films …</div>
  if (films.cameras.length === 0)
    return (
      <div class="empty">
        <h2>No films of {shot}</h2>
        <p>{films.problem}</p>
        <AddFilms shot={shot} />
      </div>
    )
  return (
    <>
      <ShotFilms shot={shot} films={films} />
      <MoreFilms shot={shot} />
    </>
  )
}

export function FilmsPage() {
  return (
    <ShotPage
      title="Films"
      kind="poses films"
      show={(shot) => <ShotPanel key={shot.name} shot={shot.name} />}
    />
  )
}
