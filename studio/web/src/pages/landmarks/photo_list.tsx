// The pairs of a template and photographs as a list, and what the last fit says of each.
import type { PhotoFit } from '../../api'
import { RowTools } from './bench_pieces'
import { RenameField, RowButton, UndoButtons } from './pair_list'
import { OlderPicks } from './older_picks'
import { colorOf, residualsOf, stateWords } from './photo_model'
import type { PhotoPicking } from './photo_picking'
import type { PhotoPair } from './pick_history'

/** The photographs of the chosen pair, to go to or to take out. */
function PixelRows(props: {
  pair: PhotoPair
  picking: PhotoPicking
  fit: PhotoFit | null
  image: string
  show: (image: string) => void
}) {
  const residuals = residualsOf(props.pair, props.fit)
  return (
    <ul class="ph-pixels">
      {props.pair.pixels.map(({ image }) => {
        const residual = residuals.find((one) => one.pick.image === image)
        return (
          <li key={image}>
            <button
              class="quiet small"
              aria-current={image === props.image ? 'true' : undefined}
              onClick={() => props.show(image)}
            >
              <span class="lm-name">{image}</span>
              {residual && (
                <span class={`number ${residual.wrong ? 'bad' : 'soft'}`}>
                  {residual.off_px.toFixed(1)} px off
                </span>
              )}
            </button>
            <button
              class="quiet"
              aria-label={`Take ${props.pair.name} out of ${image}`}
              title="Take it out of this photograph"
              onClick={() => props.picking.removePixel(props.pair.name, image)}
            >
              ×
            </button>
          </li>
        )
      })}
    </ul>
  )
}

function PhotoRow(props: {
  pair: PhotoPair
  index: number
  picking: PhotoPicking
  fit: PhotoFit | null
  image: string
  show: (image: string) => void
}) {
  const { pair, picking, fit } = props
  const { name } = pair
  const chosen = name === picking.chosen
  const open = !pair.template || pair.pixels.length === 0
  const wrong = residualsOf(pair, fit).some((one) => one.wrong)
  const problem = picking.problems.get(name) ?? ''
  if (picking.renaming === name)
    return (
      <li>
        <RenameField from={name} picking={picking} />
      </li>
    )
  return (
    <li class={chosen ? 'chosen' : ''}>
      <RowButton
        id={`pair:${name}`}
        chosen={chosen}
        title="Double click or F2 renames"
        onClick={() => picking.choose(name)}
        onDblClick={() => picking.setRenaming(name)}
      >
        <i
          class={`lm-dot ${open ? 'open' : ''}`}
          style={open ? undefined : { background: colorOf(props.index) }}
          aria-hidden="true"
        />
        <span class="lm-name">{name}</span>
        <span class={`lm-state number ${wrong ? 'bad' : ''}`}>
          {stateWords(pair, picking.template, fit)}
        </span>
      </RowButton>
      <RowTools
        name={name}
        rename={() => picking.setRenaming(name)}
        remove={() => picking.remove(name)}
      />
      {problem && <p class="lm-problem">{problem}</p>}
      {chosen && <PixelRows {...props} />}
    </li>
  )
}

export function PhotoPairList(props: {
  picking: PhotoPicking
  fit: PhotoFit | null
  image: string
  show: (image: string) => void
}) {
  const { picking } = props
  const { pairs } = picking
  const open = pairs.filter((pair) => !pair.template || pair.pixels.length === 0).length
  const general = picking.problems.get('')
  return (
    <section class="lm-pairs" aria-label="Landmarks">
      <div class="row spread">
        <h2 class="lm-title">
          Pairs · <span class="number">{pairs.length - open}</span>
          {open > 0 && <span class="lm-open"> · {open} open</span>}
        </h2>
        <UndoButtons
          undo={picking.undo}
          redo={picking.redo}
          canUndo={picking.pending !== null || picking.files.history.past.length > 0}
          canRedo={picking.files.history.future.length > 0}
        />
      </div>
      {general && <p class="small bad">{general}</p>}
      <OlderPicks picking={picking} fit={props.fit} />
      {pairs.length === 0 && picking.files.loaded && (
        <p class="small soft">
          None yet, and often none is needed: run the fit first, then pick what it has wrong. Click
          a place on {picking.template}, then the same place in a photograph.
        </p>
      )}
      <ul class="lm-rows">
        {pairs.map((pair, index) => (
          <PhotoRow key={pair.name} {...props} pair={pair} index={index} />
        ))}
      </ul>
    </section>
  )
}
