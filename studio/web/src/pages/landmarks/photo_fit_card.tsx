// 'Fit', how well the result agrees with the photographs, and where it agrees least.
import { Bar } from '../../bar'
import { api } from '../../api'
import type { PhotoFit } from '../../api'
import { useStudio } from '../../state'
import { percent } from '../../words'
import { worstPlaces } from './photo_model'
import type { WorstPlace } from './photo_model'

/** Runs a step and what it needs, after `save`; what it is at. */
export function useStepRun(id: string, save: () => Promise<void>) {
  const { steps, running, complain, reload } = useStudio()
  const step = steps.steps.find((one) => one.id === id)
  const run = async () => {
    try {
      await save()
      await api.run({ until: [id] })
      await reload()
    } catch (error) {
      complain(error)
    }
  }
  return {
    step,
    run,
    atWork: running !== null,
    at: running?.steps[id],
    overall: running?.overall ?? 0,
    locked: steps.locked_by,
  }
}

function Advice(props: { fit: PhotoFit; look: (place: WorstPlace) => void }) {
  const places = worstPlaces(props.fit)
  if (places.length === 0) return null
  return (
    <div class="ph-worst">
      <p class="small soft">
        Pick where the fit is worst, unless it is the stand that is beside it:
      </p>
      {places.map((place) => (
        <button key={place.image} class="quiet small" onClick={() => props.look(place)}>
          <b>{place.image}</b> {place.words}
        </button>
      ))}
    </div>
  )
}

export function PhotoFitCard(props: {
  pose: string
  fit: PhotoFit | null
  save: () => Promise<void>
  look: (place: WorstPlace) => void
}) {
  const { pose, fit } = props
  const { step, run, atWork, at, overall, locked } = useStepRun(`fit/${pose}`, props.save)
  const seen = fit?.photographs.filter((one) => one.iou !== null) ?? []
  const lost = fit?.photographs.filter((one) => !one.placed) ?? []
  const mean = seen.reduce((sum, one) => sum + one.iou!, 0) / Math.max(1, seen.length)
  return (
    <section class="lm-fit" aria-label="Fit">
      {fit && seen.length > 0 && (
        <>
          <div class="row spread">
            <h2 class="lm-title">Overlap with masks</h2>
            <span class="number" title="Mean of the photographs, of the last fit">
              {percent(mean, 1)}
            </span>
          </div>
          {lost.length > 0 && (
            <p class="small warn">
              No camera for {lost.map((one) => one.name).join(', ')}: pick four to six places in it
              that did not move against each other.
            </p>
          )}
          <Advice fit={fit} look={props.look} />
        </>
      )}
      {atWork && (
        <div class="stack" style="gap:4px" role="status">
          <Bar share={at?.fraction ?? overall} />
          <span class="small soft">{at?.what || 'The steps before it run first.'}</span>
        </div>
      )}
      {!atWork && step?.state === 'failed' && <p class="small bad">{step.error}</p>}
      <button
        class="main lm-wide"
        disabled={atWork || locked !== ''}
        title={locked || `Runs what ${pose} needs, up to its fit (Ctrl+Enter)`}
        data-action="fit"
        onClick={() => void run()}
      >
        {atWork ? 'Running…' : seen.length > 0 ? `Fit ${pose} again` : `Fit ${pose}`}
      </button>
    </section>
  )
}
