// Mode 'Result': the finished shot, played at its speed; which pictures were filmed and which made.
import { useEffect, useMemo, useRef, useState } from 'preact/hooks'

import { linkTo } from '../export/results'
import { useKeys } from '../../keys'
import { Icon } from '../timeline/icons'
import { Player } from '../timeline/player'
import { Sound } from '../timeline/sound'
import { RunStep, Warnings } from './camera_card'
import { shotApi } from './shot_api'
import type { Finished } from './shot_api'
import { countWords, pictureWords } from './words'

const kWidth = 1280

/** All pictures, loaded; those that are not there yet are null. */
function usePictures(finished: Finished, version: string): (HTMLImageElement | null)[] {
  const [, drawAgain] = useState(0)
  const loaded = useMemo(
    () => finished.pictures.map((): HTMLImageElement | null => null),
    [finished.pictures.length, version],
  )
  useEffect(() => {
    let current = true
    const load = async () => {
      for (const [i, { picture }] of finished.pictures.entries()) {
        const image = new Image()
        image.src = shotApi.pictureUrl('result', picture, kWidth, version)
        await image.decode().catch(() => undefined)
        if (!current) return
        loaded[i] = image
        drawAgain((old) => old + 1)
      }
    }
    void load()
    return () => {
      current = false
    }
  }, [loaded])
  return loaded
}

/** The player, and the picture at which it is. */
function usePlaying(finished: Finished) {
  const player = useMemo(() => new Player(new Sound()), [])
  player.fps = finished.fps
  player.length = finished.pictures.length
  player.range = finished.pictures.length
  const [at, setAt] = useState(0)
  const [playing, setPlaying] = useState(false)
  useEffect(() => {
    const ends = [player.watch(setAt), player.watchState(() => setPlaying(player.playing))]
    return () => {
      player.pause()
      ends.forEach((end) => end())
    }
  }, [player])
  return { player, at: Math.min(at, finished.pictures.length - 1), playing }
}

export function ResultView({ finished, version }: { finished: Finished; version: string }) {
  const pictures = usePictures(finished, version)
  const { player, at, playing } = usePlaying(finished)
  const [compared, setCompared] = useState(false)
  const canvas = useRef<HTMLCanvasElement>(null)
  const one = finished.pictures[at]
  const comparison = compared && !playing && finished.compared.includes(one.picture)
  useEffect(() => {
    const image = pictures[at]
    const context = canvas.current?.getContext('2d')
    if (!image?.naturalWidth || !context) return
    context.canvas.width = image.naturalWidth
    context.canvas.height = image.naturalHeight
    context.drawImage(image, 0, 0)
  }, [at, pictures[at], comparison])
  useKeys({
    ' ': () => player.toggle(),
    ',': () => player.seek(at - 1),
    '.': () => player.seek(at + 1),
    ArrowLeft: () => player.seek(at - 1),
    ArrowRight: () => player.seek(at + 1),
    Home: () => player.seek(0),
    End: () => player.seek(finished.pictures.length - 1),
    c: () => setCompared(!compared),
  })
  const ready = pictures.filter((picture) => picture).length
  return (
    <>
      <section class="view frame-view" aria-label="The finished shot">
        <div
          class="frame-sheet still"
          style={{
            '--ratio': String((comparison ? 3 : 1) * (finished.width / finished.height)),
          }}
        >
          {comparison ? (
            <img
              class="whole"
              src={shotApi.pictureUrl('compare', one.picture, 2 * kWidth, version)}
              alt="Filmed, rendered, and four times their difference"
            />
          ) : (
            <canvas
              ref={canvas}
              role="img"
              aria-label={`Picture ${at}, ${pictureWords(finished, at)}`}
            />
          )}
        </div>
        <span class={`tag shot-kind ${one.kind}`}>
          {one.kind === 'between' ? 'made' : one.kind}
        </span>
      </section>
      <div class="shot-play row">
        <button
          class="main"
          aria-label={playing ? 'Pause' : 'Play'}
          title={`${playing ? 'Pause' : 'Play'} (Space)`}
          onClick={() => player.toggle()}
        >
          <Icon name={playing ? 'pause' : 'play'} />
        </button>
        <span class="number">
          {at} <span class="soft">/ {finished.pictures.length - 1}</span>
        </span>
        <span class="small shot-what">{pictureWords(finished, at)}</span>
        <span class="shot-gap" />
        {ready < finished.pictures.length && (
          <span class="small soft">
            loading {ready} of {finished.pictures.length}
          </span>
        )}
        <button
          aria-pressed={compared}
          title="At a key: filmed, rendered, and four times their difference (C)"
          onClick={() => setCompared(!compared)}
        >
          Compare keys
        </button>
      </div>
      <nav class="shot-cells" aria-label="Pictures of the finished shot">
        {finished.pictures.map(({ picture, kind }, i) => (
          <button
            key={picture}
            class={kind}
            aria-current={i === at ? 'true' : undefined}
            aria-label={`Picture ${i}, ${kind === 'between' ? 'made' : kind}`}
            title={pictureWords(finished, i)}
            tabIndex={i === at ? 0 : -1}
            onClick={() => player.seek(i)}
          />
        ))}
      </nav>
    </>
  )
}

export function ResultCard({ finished }: { finished: Finished | null }) {
  return (
    <section class="stack" aria-label="Result">
      <h2 class="shot-title">Result</h2>
      {finished ? (
        <>
          <p class="small">
            {countWords(finished)}, at {finished.fps} pictures a second.
          </p>
          <table class="small number">
            <thead>
              <tr>
                <th>Key</th>
                <th title="Of the render at a key and its filmed frame, in the character's box">
                  PSNR
                </th>
                <th title="Distance of the outlines of render and filmed frame">Edges</th>
              </tr>
            </thead>
            <tbody>
              {finished.joins.map((join) => (
                <tr key={join.picture}>
                  <td>
                    {join.picture} {join.pose}
                  </td>
                  <td>{join.psnr_db.toFixed(1)} dB</td>
                  <td>{join.edge_px.toFixed(2)} px</td>
                </tr>
              ))}
            </tbody>
          </table>
          <p class="small soft">How well a made picture joins the filmed ones at the keys.</p>
        </>
      ) : (
        <p class="small soft">Not made yet.</p>
      )}
      <Warnings step="composite" />
      <div class="row">
        <RunStep
          step="composite"
          name="Make the pictures"
          again="Make them again"
          there={finished !== null}
        />
        {finished?.video && (
          <a class="button" href={linkTo(finished.video)} download="shot.mp4">
            MP4
          </a>
        )}
      </div>
    </section>
  )
}
