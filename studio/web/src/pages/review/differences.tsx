// What was changed between two results, and the figures that moved.
import type { Compared, Figure } from './review_api'
import { numberWords, trend } from './review_model'

export function Differences({ compared }: { compared: Compared | null }) {
  if (!compared) return null
  const main = compared.figures.filter((figure) => figure.main)
  const others = compared.figures.filter((figure) => !figure.main)
  return (
    <>
      <section class="stack" aria-label="What was changed">
        <h2 class="label">What was changed</h2>
        {compared.changes.length > 0 && (
          <ul class="rv-changes">
            {compared.changes.map(({ step, title, text }) => (
              <li key={`${step} ${text}`}>
                <span class="small soft">
                  {title}
                  {step.includes('/') && ` · ${step.split('/')[1]}`}
                </span>
                <span>{text.replaceAll(' -> ', ' → ')}</span>
              </li>
            ))}
          </ul>
        )}
        {compared.unknown.length > 0 && (
          <p class="small soft">
            Of {compared.unknown.join(', ')} an older result was cleaned away, so what was changed
            there is not known.
          </p>
        )}
        {compared.changes.length + compared.unknown.length === 0 && (
          <p class="small soft">Nothing.</p>
        )}
      </section>
      <section class="stack" aria-label="Figures that moved">
        <h2 class="label">Figures that moved</h2>
        {compared.figures.length === 0 && <p class="small soft">None.</p>}
        {main.length > 0 && <Figures figures={main} caption="The most important ones" />}
        {others.length > 0 && (
          <details>
            <summary class="small">
              {others.length} more {others.length === 1 ? 'figure' : 'figures'}
            </summary>
            <Figures figures={others} caption="All others" />
          </details>
        )}
      </section>
    </>
  )
}

function Figures({ figures, caption }: { figures: Figure[]; caption: string }) {
  return (
    <table class="rv-figures small">
      <caption class="hidden">{caption}</caption>
      <thead>
        <tr>
          <th scope="col">Figure</th>
          <th scope="col">Before</th>
          <th scope="col">After</th>
        </tr>
      </thead>
      <tbody>
        {figures.map((figure) => {
          const to = trend(figure)
          return (
            <tr key={`${figure.step} ${figure.key}`}>
              <td>
                {figure.label}
                <span class="soft"> · {figure.title}</span>
              </td>
              <td class="number">{numberWords(figure.before, figure.unit)}</td>
              <td class={`number ${to === 'worse' ? 'bad' : to === 'better' ? 'good' : ''}`}>
                {numberWords(figure.after, figure.unit)}
                {to && <span class="rv-trend"> {to}</span>}
              </td>
            </tr>
          )
        })}
      </tbody>
    </table>
  )
}
